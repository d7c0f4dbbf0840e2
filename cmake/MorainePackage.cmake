# `cmake --install` and the Debian package (`cpack -G DEB` in the build folder): the program, and what it starts or points to.
#
#   bin/moraine
#   share/moraine/{report,package,python/moraine}   scripts and the Python package: moraine report, picture, converge
#   share/moraine/inputs                            scenes to begin with, and every key
include(GNUInstallDirs)
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)  # what is installed needs neither tests nor benchmarks
set(share ${CMAKE_INSTALL_DATADIR}/moraine)
set(rights FILE_PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
install(TARGETS moraine RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY scripts/report scripts/package DESTINATION ${share} ${rights} FILES_MATCHING PATTERN "*.py" PATTERN __pycache__ EXCLUDE)
install(DIRECTORY python/moraine DESTINATION ${share}/python ${rights} FILES_MATCHING PATTERN "*.py" PATTERN py.typed PATTERN __pycache__ EXCLUDE)
install(DIRECTORY inputs DESTINATION ${share} ${rights} PATTERN __pycache__ EXCLUDE)
install(FILES README.md CHANGELOG.md CITATION.cff DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME moraine)
set(CPACK_PACKAGE_VENDOR "The Moraine developers")
set(CPACK_PACKAGE_CONTACT "The Moraine developers")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "Landslides, submarine slides, mud and collapsing grains. Blocks of the ground
change owner while the flow moves, so that every rank keeps an equal share of
the work; answers are the same to the bit on any number of ranks.")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "openmpi-bin, python3-h5py, python3-matplotlib")
if(MORAINE_GDAL)  # loaded by a scene that has such files (io/gdal_library.hpp)
    string(REGEX REPLACE "^libgdal\\.so\\." "libgdal" CPACK_DEBIAN_PACKAGE_SUGGESTS ${MORAINE_GDAL_LIBRARY})
endif()
include(CPack)
