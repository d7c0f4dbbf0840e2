# Flags of every target. One answer to the bit needs -ffp-contract=off and never -ffast-math: g++
# contracts the vector body and the scalar tail of a loop differently. std::fma is written where it pays.
include(CMakeDependentOption)
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE)
    set(CMAKE_BUILD_TYPE Release)
endif()
set(CMAKE_CXX_FLAGS_RELEASE "-O3 -DNDEBUG")

option(MORAINE_SANITIZE "Address and undefined behaviour sanitizers" OFF)
option(MORAINE_WERROR "Warnings are errors: for developers, not for compilers that nobody has tried" OFF)
if(DEFINED ENV{MORAINE_WERROR})
    set(MORAINE_WERROR $ENV{MORAINE_WERROR} CACHE BOOL "Warnings are errors" FORCE)
endif()
option(MORAINE_CHECK_HEADERS "Compile every header alone (target all_verify_interface_header_sets)" OFF)

# x86-64-v3 (AVX2, FMA: any server of the last ten years) where this machine has it, else the compiler's own.
if(NOT DEFINED MORAINE_MARCH)
    include(CheckCXXSourceRuns)
    check_cxx_source_runs("int main() { return !(__builtin_cpu_supports(\"avx2\") && __builtin_cpu_supports(\"fma\")); }"
        MORAINE_HAS_AVX2)
    if(MORAINE_HAS_AVX2)
        set(MORAINE_MARCH x86-64-v3 CACHE STRING "-march of the host code (empty: none)" FORCE)
    else()
        set(MORAINE_MARCH "" CACHE STRING "-march of the host code (empty: none)" FORCE)
    endif()
endif()

# The transfers and laws once more for AVX-512, which a run chooses (core/data/processor.hpp): where compiler and binutils can.
include(CheckCXXCompilerFlag)
set(MORAINE_AVX512_OPTIONS -mavx512f -mavx512bw -mavx512dq -mavx512vl -mfma -mtune=sapphirerapids)
string(REPLACE ";" " " options "${MORAINE_AVX512_OPTIONS}")
check_cxx_compiler_flag("${options}" MORAINE_COMPILES_AVX512)
if(MORAINE_COMPILES_AVX512 AND CMAKE_LINKER AND CMAKE_OBJCOPY AND CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    set(MORAINE_HAS_AVX512 ON)
endif()
option(MORAINE_AVX512 "Transfers and laws for AVX-512 besides, chosen at run time" ${MORAINE_HAS_AVX512})

add_library(moraine_flags INTERFACE)
target_compile_definitions(moraine_flags INTERFACE OMPI_SKIP_MPICXX=1)
function(moraine_host_options)
    foreach(option ${ARGN})
        target_compile_options(moraine_flags INTERFACE $<$<COMPILE_LANGUAGE:C,CXX>:${option}>)
    endforeach()
endfunction()
set(MORAINE_ANSWER_OPTIONS -ffp-contract=off -fno-math-errno)  # laws in files take them, too (src/compile)
if(MORAINE_MARCH)
    list(APPEND MORAINE_ANSWER_OPTIONS -march=${MORAINE_MARCH})
endif()
moraine_host_options(-Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -Wno-unknown-pragmas
    ${MORAINE_ANSWER_OPTIONS})
# Device code: no -march (a register of the host is no type of the device); what its files do on the host keeps the rules.
target_compile_options(moraine_flags INTERFACE
    $<$<COMPILE_LANGUAGE:CUDA>:--expt-relaxed-constexpr -lineinfo -Xcompiler=-Wall,-ffp-contract=off,-fopenmp>)
if(MORAINE_WERROR)
    moraine_host_options(-Werror)
    target_compile_options(moraine_flags INTERFACE $<$<COMPILE_LANGUAGE:CUDA>:-Werror=all-warnings>)
endif()
if(MORAINE_SANITIZE)
    moraine_host_options(-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(moraine_flags INTERFACE -fsanitize=address,undefined)
endif()

# A test's own code runs for moments, and is compiled as often as it is changed. The libraries that it tests have -O3.
# With -O1 g++ 12 sees strings written out of their bounds that are not.
add_library(moraine_test_flags INTERFACE)
target_compile_options(moraine_test_flags INTERFACE "$<$<AND:$<CONFIG:Release>,$<COMPILE_LANGUAGE:CXX>>:-O1;-Wno-array-bounds;-Wno-stringop-overflow>")

# The standard library is read once, and not by each of some 450 files: a fifth of the build. A compiler cache does better
# without: it would have to be told to trust such a header.
if(CMAKE_CXX_COMPILER_LAUNCHER)
    set(MORAINE_CACHES_OBJECTS ON)
endif()
cmake_dependent_option(MORAINE_PRECOMPILE "Precompile the headers of the standard library" ON "NOT MORAINE_CACHES_OBJECTS" OFF)
if(MORAINE_PRECOMPILE)
    file(WRITE ${CMAKE_BINARY_DIR}/standard.cpp "")
endif()
# moraine_precompiled(name [LINKS target...] [HEADERS header...]): the standard library and these headers, precompiled.
function(moraine_precompiled name)
    cmake_parse_arguments(ARG "" "" "LINKS;HEADERS" ${ARGN})
    if(MORAINE_PRECOMPILE)
        add_library(${name} STATIC ${CMAKE_BINARY_DIR}/standard.cpp)
        target_link_libraries(${name} PRIVATE moraine_flags OpenMP::OpenMP_CXX ${ARG_LINKS})
        target_precompile_headers(${name} PRIVATE <algorithm> <array> <chrono> <cmath> <cstdint> <filesystem> <fstream> <functional>
            <limits> <map> <memory> <numeric> <optional> <random> <span> <sstream> <string> <string_view> <tuple> <vector> ${ARG_HEADERS})
    endif()
endfunction()
moraine_precompiled(moraine_standard)
if(MORAINE_TESTS)
    moraine_precompiled(moraine_standard_doctest LINKS doctest_header moraine_test_flags HEADERS <doctest/doctest.h>)
endif()
