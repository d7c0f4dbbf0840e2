# moraine_module(NAME [USES target...] HEADERS file... [SOURCES file...] [PRECOMPILED target])
#
# One library per folder of src. With MORAINE_CHECK_HEADERS the target
# all_verify_interface_header_sets compiles every header alone.
function(moraine_module name)
    cmake_parse_arguments(ARG "" "PRECOMPILED" "USES;HEADERS;SOURCES" ${ARGN})
    if(ARG_SOURCES)
        add_library(moraine_${name} STATIC ${ARG_SOURCES})
        set(scope PUBLIC)
    else()
        add_library(moraine_${name} INTERFACE)
        set(scope INTERFACE)
    endif()
    target_include_directories(moraine_${name} ${scope} ${CMAKE_SOURCE_DIR}/src)
    target_link_libraries(moraine_${name} ${scope} moraine_flags ${ARG_USES})
    target_sources(moraine_${name} ${scope} FILE_SET HEADERS BASE_DIRS ${CMAKE_SOURCE_DIR}/src FILES ${ARG_HEADERS})
    set_target_properties(moraine_${name} PROPERTIES VERIFY_INTERFACE_HEADER_SETS ${MORAINE_CHECK_HEADERS})
    if(ARG_SOURCES)
        if(NOT ARG_PRECOMPILED)
            set(ARG_PRECOMPILED moraine_standard)
        endif()
        moraine_precompile(moraine_${name} ${ARG_PRECOMPILED})
    endif()
endfunction()

# moraine_precompile(target precompiled): the target takes the precompiled header of another one, with whose flags it is
# compiled. What a file uses it includes all the same: headers are checked without (MORAINE_CHECK_HEADERS).
function(moraine_precompile name precompiled)
    if(TARGET ${precompiled})
        target_precompile_headers(${name} REUSE_FROM ${precompiled})
    endif()
endfunction()

# Longest time of a test [s]: sanitizers and assertions make it some 5 to 10 times slower.
set(MORAINE_TEST_TIMEOUT 600)
if(MORAINE_SANITIZE OR CMAKE_BUILD_TYPE STREQUAL "Debug")
    set(MORAINE_TEST_TIMEOUT 3600)
endif()

# Of tests that start ranks: as root, on one machine, so that ranks which wait leave the core to others; and of sanitizers.
set(MORAINE_TEST_ENVIRONMENT "OMPI_ALLOW_RUN_AS_ROOT=1" "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1"
    "OMPI_MCA_rmaps_base_oversubscribe=1" "OMPI_MCA_hwloc_base_binding_policy=none" "OMPI_MCA_mpi_yield_when_idle=1"
    "LSAN_OPTIONS=suppressions=${CMAKE_SOURCE_DIR}/tests/leaks.supp:print_suppressions=0"
    "ASAN_OPTIONS=detect_leaks=1:fast_unwind_on_malloc=0")

# moraine_test(path/test_name [RANKS n...] [USES target...] [SOURCES file...] [ENVIRONMENT VAR=value...] [GPU] [LANGUAGE cu])
#
# tests/path/test_name.cpp becomes one program; with RANKS it runs once per count under mpirun; with GPU it needs a
# device, and is skipped where there is none. Of 2 cores (CMakePresets.json) it takes as many as it has ranks.
function(moraine_test path)
    cmake_parse_arguments(ARG "GPU" "TIMEOUT;LANGUAGE" "RANKS;USES;SOURCES;ENVIRONMENT" ${ARGN})
    string(REPLACE "/" "." name ${path})
    if(NOT ARG_LANGUAGE)
        set(ARG_LANGUAGE cpp)
    endif()
    add_executable(${name} ${CMAKE_SOURCE_DIR}/tests/${path}.${ARG_LANGUAGE} ${ARG_SOURCES})
    target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR}/tests)
    target_link_libraries(${name} PRIVATE ${ARG_USES} moraine_flags moraine_test_flags doctest_header)
    if(NOT ARG_GPU AND ARG_USES MATCHES "moraine_(simulation|records)")
        moraine_precompile(${name} moraine_simulation_doctest)
    else()
        moraine_precompile(${name} moraine_standard_doctest)
    endif()
    if(NOT ARG_TIMEOUT)
        set(ARG_TIMEOUT ${MORAINE_TEST_TIMEOUT})
    endif()
    set(environment "OMP_NUM_THREADS=1" ${MORAINE_TEST_ENVIRONMENT} ${ARG_ENVIRONMENT})
    if(ARG_RANKS)
        target_link_libraries(${name} PRIVATE $<IF:$<BOOL:${ARG_GPU}>,moraine_gpu_main,moraine_mpi_main>)
        foreach(n ${ARG_RANKS})
            set(processors 2)
            if(n EQUAL 1)
                set(processors 1)
            endif()
            add_test(NAME ${name}.${n} COMMAND ${MPIEXEC_EXECUTABLE} ${MPIEXEC_NUMPROC_FLAG} ${n} $<TARGET_FILE:${name}>)
            set_tests_properties(${name}.${n} PROPERTIES ENVIRONMENT "${environment}" PROCESSORS ${processors} TIMEOUT ${ARG_TIMEOUT}
                SKIP_RETURN_CODE 77)
        endforeach()
    else()
        target_link_libraries(${name} PRIVATE $<IF:$<BOOL:${ARG_GPU}>,moraine_gpu_main,moraine_main>)
        add_test(NAME ${name} COMMAND ${name})
        set_tests_properties(${name} PROPERTIES ENVIRONMENT "${environment}" TIMEOUT ${ARG_TIMEOUT} SKIP_RETURN_CODE 77)
    endif()
endfunction()
