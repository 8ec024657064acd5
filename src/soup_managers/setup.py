"""Installs the ROS 2 package soup_managers."""

from setuptools import find_packages, setup

NAME = "soup_managers"

setup(
    name=NAME,
    version="0.1.0",
    description="Word, letter and fleet managers with their policies and planners, and their nodes.",
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
            "word_manager = soup_managers.nodes.word_manager_node:main",
            "letter_manager = soup_managers.nodes.letter_manager_node:main",
            "fleet_manager = soup_managers.nodes.fleet_manager_node:main",
        ],
    },
)
