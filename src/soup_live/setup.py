"""Installs the ROS 2 package soup_live."""

from setuptools import find_packages, setup

NAME = "soup_live"

setup(
    name=NAME,
    version="0.1.0",
    description="What any process of the live graph is made of: discovery, leader election, world client.",
    maintainer="The Alphabet Soup maintainers",
    maintainer_email="maintainers@alphabet-soup.invalid",
    license="Apache-2.0",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    include_package_data=True,
    package_data={NAME: ["py.typed", "**/*.html", "**/*.css", "**/*.js", "**/*.svg", "**/*.yaml", "**/*.xml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    zip_safe=False,
)
