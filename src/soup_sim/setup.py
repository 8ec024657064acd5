"""Installs the ROS 2 package soup_sim."""

from setuptools import find_packages, setup

NAME = "soup_sim"

setup(
    name=NAME,
    version="0.1.0",
    description="The warehouse world: physics, stations, orders, layouts, statistics, its node.",
    maintainer="The Alphabet Soup maintainers",
    maintainer_email="maintainers@alphabet-soup.invalid",
    license="Apache-2.0",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    include_package_data=True,
    package_data={NAME: ["py.typed", "**/*.html", "**/*.css", "**/*.js", "**/*.svg", "**/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "world = soup_sim.world_program:main",
        ],
    },
)
