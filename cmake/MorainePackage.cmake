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
# Device kernels of the shipped scenes, for machines without NVRTC: compiled when the package is built.
set(MORAINE_DEVICE_KERNELS demand CACHE STRING "demand: a run compiles what it wants; ahead: a package brings those of the shipped scenes")
if(MORAINE_CUDA AND MORAINE_DEVICE_KERNELS STREQUAL ahead)
    file(GLOB scenes ${CMAKE_SOURCE_DIR}/inputs/*.toml)
    list(FILTER scenes EXCLUDE REGEX reference)
    string(REGEX MATCHALL "[0-9]+" architectures "${MORAINE_CUDA_ARCHITECTURES}")
    list(TRANSFORM architectures PREPEND --architecture=)
    set(commands)
    foreach(scene ${scenes})
        list(APPEND commands COMMAND moraine kernels ${scene} ${architectures} --kernel-cache=${CMAKE_BINARY_DIR}/kernels)
    endforeach()
    add_custom_target(kernels_ahead ALL ${commands} VERBATIM)
    install(DIRECTORY ${CMAKE_BINARY_DIR}/kernels DESTINATION ${share} FILES_MATCHING PATTERN "*.kernels")
endif()
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
