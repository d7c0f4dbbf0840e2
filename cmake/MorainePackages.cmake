set(MPI_CXX_SKIP_MPICXX ON)  # Open MPI's old C++ bindings warn under -Wextra
find_package(MPI REQUIRED COMPONENTS C CXX)
find_package(OpenMP REQUIRED COMPONENTS CXX)
find_package(fmt REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(Boost REQUIRED COMPONENTS program_options)
set(HDF5_PREFER_PARALLEL ON)
find_package(HDF5 REQUIRED COMPONENTS C)
if(NOT HDF5_IS_PARALLEL)
    message(FATAL_ERROR "HDF5 without MPI found (checkpoints are written by all ranks). Install libhdf5-openmpi-dev?")
endif()

# Debian's Zoltan exports a CMake package without include directories and with hard-coded libraries;
# METIS has none: both get a target of our own.
function(moraine_import name header library)
    find_path(${name}_INCLUDE_DIR ${header} PATH_SUFFIXES trilinos REQUIRED)
    find_library(${name}_LIBRARY NAMES ${library} REQUIRED)
    add_library(${name}::${name} UNKNOWN IMPORTED)
    set_target_properties(${name}::${name} PROPERTIES IMPORTED_LOCATION ${${name}_LIBRARY}
        INTERFACE_INCLUDE_DIRECTORIES ${${name}_INCLUDE_DIR})
endfunction()
moraine_import(METIS metis.h metis)
moraine_import(Zoltan zoltan.h trilinos_zoltan)
target_link_libraries(Zoltan::Zoltan INTERFACE MPI::MPI_C)

option(MORAINE_TESTS "Build the tests" ON)
option(MORAINE_BENCHMARKS "Build the benchmarks" ON)
if(MORAINE_TESTS)
    find_path(DOCTEST_INCLUDE_DIR doctest/doctest.h REQUIRED)
    add_library(doctest_header INTERFACE)
    target_include_directories(doctest_header SYSTEM INTERFACE ${DOCTEST_INCLUDE_DIR})
endif()
