# One target a folder.

# Headers that most sources include cost more than the sources: they are precompiled, in three sets, once for
# all libraries and once for all tests. Sources still include what they use, and say with PRECOMPILED which
# set that is: nothing for the common headers, `messages` for these, jobs and scenes, `rpc` for jobs and the
# services.
set(TESSERA_HEADERS_common <algorithm> <chrono> <cmath> <functional> <memory> <optional> <string>
  <unordered_map> <vector>
    <absl/status/statusor.h> <absl/strings/str_cat.h>)
set(TESSERA_HEADERS_messages ${TESSERA_HEADERS_common} <tessera/v1/job.pb.h> <tessera/v1/scene.pb.h>)
set(TESSERA_HEADERS_rpc ${TESSERA_HEADERS_common} <tessera/v1/job.pb.h> <grpcpp/grpcpp.h>
  <tessera/v1/blob.grpc.pb.h>
    <tessera/v1/farm.grpc.pb.h> <tessera/v1/work.grpc.pb.h>)
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/headers.cpp CONTENT "")

# Test code is run once for each time that it is compiled; what it tests is optimised as it ships.
set(TESSERA_TEST_FLAGS $<$<CONFIG:Release>:-O1>)

foreach(set common messages rpc)
  add_library(tessera_${set}_headers OBJECT ${CMAKE_BINARY_DIR}/headers.cpp)
  target_link_libraries(tessera_${set}_headers PRIVATE absl::statusor absl::strings tessera_options)
  target_precompile_headers(tessera_${set}_headers PRIVATE ${TESSERA_HEADERS_${set}})
  set(targets tessera_${set}_headers)
  if(TESSERA_TESTS)
    # The same for programs: -fPIE, not -fPIC.
    add_library(tessera_${set}_test_headers OBJECT ${CMAKE_BINARY_DIR}/headers.cpp)
    set_target_properties(tessera_${set}_test_headers PROPERTIES POSITION_INDEPENDENT_CODE OFF)
    target_compile_options(tessera_${set}_test_headers PRIVATE -fPIE ${TESSERA_TEST_FLAGS})
    target_link_libraries(tessera_${set}_test_headers PRIVATE absl::statusor absl::strings GTest::gtest
      tessera_options)
    target_precompile_headers(tessera_${set}_test_headers PRIVATE ${TESSERA_HEADERS_${set}} <gtest/gtest.h>)
    list(APPEND targets tessera_${set}_test_headers)
  endif()
  foreach(target ${targets})
    if(set STREQUAL "messages")
      target_link_libraries(${target} PRIVATE tessera_proto)
    elseif(set STREQUAL "rpc")
      target_link_libraries(${target} PRIVATE tessera_proto_grpc)
    endif()
  endforeach()
endforeach()

# tessera_precompiled(TARGET SET KIND): lets the target use the headers above; KIND is "" for libraries,
# "test" for tests.
function(tessera_precompiled target set kind)
  if(NOT set)
    set(set common)
  endif()
  if(kind)
    set(kind _${kind})
  endif()
  target_precompile_headers(${target} REUSE_FROM tessera_${set}${kind}_headers)
endfunction()

# tessera_in_batches(TARGET): compiles sources several at a time, as one: what their headers bring is then
# compiled once a batch, and that is more than half of the time of a source that uses messages, services or
# GoogleTest (docs/decisions/0025). The sources share one scope: a name that two of them mean differently has
# to be told apart. Kernels are not: it would decide what is inlined in them.
set(TESSERA_BATCH 16 CACHE STRING "Sources that are compiled as one; 1: each by itself")
function(tessera_in_batches target)
  if(TESSERA_BATCH GREATER 1)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${TESSERA_BATCH})
  endif()
endfunction()

# tessera_library(NAME SOURCES... [DEPENDS targets...] [PRECOMPILED set]): a static library of this folder.
# The include root is the top-level folder that it lies in (proto/, lib/, server/, worker/, client/).
function(tessera_library name)
  cmake_parse_arguments(arg "" "PRECOMPILED" "DEPENDS" ${ARGN})
  add_library(${name} STATIC ${arg_UNPARSED_ARGUMENTS})
  string(REGEX MATCH "^${CMAKE_SOURCE_DIR}/[a-z]+" root ${CMAKE_CURRENT_SOURCE_DIR})
  target_include_directories(${name} PUBLIC ${root})
  target_link_libraries(${name} PUBLIC ${arg_DEPENDS} PRIVATE tessera_options)
  tessera_precompiled(${name} "${arg_PRECOMPILED}" "")
  tessera_in_batches(${name})
endfunction()

# tessera_program(NAME main.cpp DEPENDS targets... [PRECOMPILED set]): a program, to be installed; its main()
# is NAME-main, for programs that add to it.
function(tessera_program name main)
  cmake_parse_arguments(arg "" "PRECOMPILED" "DEPENDS" ${ARGN})
  add_library(${name}-main OBJECT ${main})
  target_link_libraries(${name}-main PUBLIC ${arg_DEPENDS} PRIVATE tessera_options)
  tessera_precompiled(${name}-main "${arg_PRECOMPILED}" "")
  add_executable(${name})
  target_link_libraries(${name} PRIVATE ${name}-main)
  tessera_installed_program(${name})
endfunction()

# The environment of every test, and of all that it starts.
set(TESSERA_TEST_ENVIRONMENT)
if(TESSERA_SANITIZE)
  # A sanitizer's own dlopen() looks for modules along the sanitizer's run path, not the program's.
  list(APPEND TESSERA_TEST_ENVIRONMENT "LD_LIBRARY_PATH=${CMAKE_LIBRARY_OUTPUT_DIRECTORY}")
endif()
if(TESSERA_SANITIZE MATCHES "address")
  list(APPEND TESSERA_TEST_ENVIRONMENT "ASAN_OPTIONS=fast_unwind_on_malloc=0"
    "LSAN_OPTIONS=suppressions=${CMAKE_SOURCE_DIR}/tests/support/lsan.supp")
endif()
if(TESSERA_SANITIZE MATCHES "thread")
  list(APPEND TESSERA_TEST_ENVIRONMENT
    "TSAN_OPTIONS=ignore_noninstrumented_modules=1:suppressions=${CMAKE_SOURCE_DIR}/tests/support/tsan.supp")
endif()

# tessera_test_entry(NAME COMMAND command... [TIMEOUT seconds] [LONG seconds] [LABELS labels...]): what CTest
# runs; after half an hour, if not told otherwise, it hangs. With LONG, and that timeout, also the long form
# (tests/support/long_form.h), the entry NAME_long, labelled `long`. The working directory is the source tree's
# root.
function(tessera_test_entry name)
  cmake_parse_arguments(arg "" "TIMEOUT;LONG" "COMMAND;LABELS" ${ARGN})
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 1800)
  endif()
  get_property(names GLOBAL PROPERTY TESSERA_TEST_NAMES)
  if(name IN_LIST names)
    message(FATAL_ERROR "Two tests are called ${name}.")
  endif()
  set_property(GLOBAL APPEND PROPERTY TESSERA_TEST_NAMES ${name})
  add_test(NAME ${name} COMMAND ${arg_COMMAND} WORKING_DIRECTORY ${CMAKE_SOURCE_DIR})
  set_tests_properties(${name} PROPERTIES TIMEOUT ${arg_TIMEOUT} SKIP_RETURN_CODE 77 LABELS "${arg_LABELS}"
    ENVIRONMENT "${TESSERA_TEST_ENVIRONMENT}")
  if("integration" IN_LIST arg_LABELS OR "load" IN_LIST arg_LABELS)
    # Farms wait more than they work: they begin first, some at a time (deploy/resources.json), and the others
    # run beside them.
    set_tests_properties(${name} PROPERTIES COST 1000 RESOURCE_GROUPS "farms:1")
  endif()
  if(arg_LONG)
    add_test(NAME ${name}_long COMMAND ${arg_COMMAND} WORKING_DIRECTORY ${CMAKE_SOURCE_DIR})
    set_tests_properties(${name}_long PROPERTIES TIMEOUT ${arg_LONG} SKIP_RETURN_CODE 77 LABELS
      "${arg_LABELS};long"
      ENVIRONMENT "TESSERA_TEST_FORM=long;${TESSERA_TEST_ENVIRONMENT}")
  endif()
endfunction()

# tessera_tests_of(SOURCES VARIABLE): the argument by which a program runs the tests of these sources alone.
function(tessera_tests_of sources variable)
  list(FILTER sources INCLUDE REGEX "_test\\.cpp$")
  list(TRANSFORM sources REPLACE ".*/" "")
  list(JOIN sources "," sources)
  set(${variable} --sources=${sources} PARENT_SCOPE)
endfunction()

# Test code, and libraries of it, alike: what is precompiled for tests is for these flags.
function(tessera_compiled_as_test target)
  cmake_parse_arguments(arg "" "PRECOMPILED" "" ${ARGN})
  target_include_directories(${target} PUBLIC ${CMAKE_SOURCE_DIR}/tests)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
  target_compile_options(${target} PRIVATE -fPIE ${TESSERA_TEST_FLAGS})
  target_link_libraries(${target} PRIVATE tessera_options)
  tessera_precompiled(${target} "${arg_PRECOMPILED}" test)
  tessera_in_batches(${target})
endfunction()

# tessera_test_library(NAME SOURCES... DEPENDS targets... [PRECOMPILED set]): what several test programs
# share.
function(tessera_test_library name)
  cmake_parse_arguments(arg "" "PRECOMPILED" "DEPENDS" ${ARGN})
  add_library(${name} STATIC ${arg_UNPARSED_ARGUMENTS})
  target_link_libraries(${name} PUBLIC ${arg_DEPENDS} PRIVATE GTest::gtest)
  tessera_compiled_as_test(${name} PRECOMPILED "${arg_PRECOMPILED}")
endfunction()

# tessera_test_program(NAME [SOURCES...] DEPENDS targets... [PRECOMPILED set]): a GoogleTest program, without
# any entry.
function(tessera_test_program name)
  cmake_parse_arguments(arg "" "PRECOMPILED" "DEPENDS" ${ARGN})
  add_executable(${name} ${arg_UNPARSED_ARGUMENTS})
  target_link_libraries(${name} PRIVATE ${arg_DEPENDS} tessera_test_main GTest::gmock GTest::gtest)
  tessera_compiled_as_test(${name} PRECOMPILED "${arg_PRECOMPILED}")
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
endfunction()

# tessera_test(NAME SOURCES... DEPENDS targets... [PRECOMPILED set | IN program] [LABELS labels...] [TIMEOUT
# seconds] [LONG seconds]): a ctest entry and the program that it runs; or, with IN, tests in the program of
# several entries, which costs less to build.
function(tessera_test name)
  cmake_parse_arguments(arg "" "IN;PRECOMPILED;TIMEOUT;LONG" "DEPENDS;LABELS" ${ARGN})
  if(arg_IN)
    target_sources(${arg_IN} PRIVATE ${arg_UNPARSED_ARGUMENTS})
    target_link_libraries(${arg_IN} PRIVATE ${arg_DEPENDS})
    tessera_tests_of("${arg_UNPARSED_ARGUMENTS}" sources)
    set(command ${arg_IN} ${sources})
  else()
    tessera_test_program(${name} ${arg_UNPARSED_ARGUMENTS} DEPENDS ${arg_DEPENDS} PRECOMPILED
      "${arg_PRECOMPILED}")
    set(command ${name})
  endif()
  tessera_test_entry(${name} COMMAND ${command} TIMEOUT "${arg_TIMEOUT}" LONG "${arg_LONG}"
    LABELS ${arg_LABELS})
endfunction()

# Kernels: code in namespace tessera::render::TESSERA_ISA, compiled once for every ISA that this processor
# family has. Each ISA's objects are linked into one module that exports a single function
# and its build's name (worker/render/kernel/kernel_module.h), so that no inline function compiled for a newer ISA can be picked up by
# code that must run everywhere.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set(known_isas avx2 avx512)
  set(TESSERA_ISA_FLAGS_avx2 -mavx2 -mfma -mf16c -mbmi -mbmi2 -mlzcnt -mpopcnt -maes -mpclmul)
  set(TESSERA_ISA_FLAGS_avx512 ${TESSERA_ISA_FLAGS_avx2} -mavx512f -mavx512dq -mavx512bw -mavx512vl -mavx512cd
      -mprefer-vector-width=512)
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "aarch64|arm64")
  set(known_isas neon)
  # Highway's NEON functions are for processors with cryptography, and GCC inlines them into code for the same
  # only. The kernels call none that needs it, so they run without as well (deploy/arm64.sh checks that).
  set(TESSERA_ISA_FLAGS_neon -march=armv8-a+crypto)
else()
  message(FATAL_ERROR "There are kernels for x86-64 and 64-bit ARM, but none for ${CMAKE_SYSTEM_PROCESSOR}.")
endif()
# Fewer for builds that are slow (sanitizers); with none, tests that need kernels are not built.
set(TESSERA_ISAS ${known_isas} CACHE STRING "Instruction sets that kernels are built for")
# GCC copies structs of vectors in 16-byte pieces otherwise, and stalls on forwarding them (measured on AVX2:
# 1.3 to 6 times the time of a BSDF).
include(CheckCXXCompilerFlag)
check_cxx_compiler_flag("-mmove-max=256 -mstore-max=256" TESSERA_HAS_MOVE_MAX)
if(TESSERA_HAS_MOVE_MAX AND TESSERA_ISA_FLAGS_avx2)
  list(APPEND TESSERA_ISA_FLAGS_avx2 -mmove-max=256 -mstore-max=256)
endif()
# Products and sums are fused where the source says fma(), and nowhere else: what a compiler fuses by itself
# depends on its version and on how functions are cut, and with it the bits of every picture
# (docs/decisions/0024).
set(TESSERA_KERNEL_FLAGS -O3 -fno-math-errno -fno-trapping-math -ffp-contract=off)
# GCC 12 forgets, once they are precompiled, that its own intrinsics leave a value undefined on purpose.
list(APPEND TESSERA_KERNEL_FLAGS -Wno-uninitialized)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  list(APPEND TESSERA_KERNEL_FLAGS -Wno-maybe-uninitialized)
endif()

if(TESSERA_SANITIZE)
  # Checks that additions to pointers do not overflow make a kernel take ten times as long to compile (Clang
  # 14: 53 s instead of 5 s).
  list(APPEND TESSERA_KERNEL_FLAGS -O1 -fno-sanitize=pointer-overflow)
endif()

# Highway's headers are half of the compiler's work on a kernel: precompiled once an ISA, by
# tessera_wide_kernel_<isa>. Whoever uses them must have the very same flags, -fPIC among them.
foreach(isa ${TESSERA_ISAS})
  set(name tessera_wide_kernel_${isa})
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/wide_kernel.cpp CONTENT "")
  add_library(${name} OBJECT ${CMAKE_BINARY_DIR}/wide_kernel.cpp)
  target_include_directories(${name} PUBLIC ${CMAKE_SOURCE_DIR}/worker ${CMAKE_SOURCE_DIR}/proto
    ${CMAKE_SOURCE_DIR}/lib)
  target_compile_definitions(${name} PUBLIC TESSERA_ISA=${isa})
  target_compile_options(${name} PUBLIC ${TESSERA_ISA_FLAGS_${isa}} ${TESSERA_KERNEL_FLAGS})
  target_link_libraries(${name} PUBLIC hwy::hwy tessera_options)
  target_precompile_headers(${name} PRIVATE ${CMAKE_SOURCE_DIR}/worker/render/core/wide.h)

  if(TESSERA_TESTS)
    # Where the processor lacks the ISA, its tests are skipped by code without it.
    add_library(tessera_skip_missing_${isa} OBJECT
      ${CMAKE_SOURCE_DIR}/tests/support/kernel/skip_missing_isa.cpp)
    target_compile_definitions(tessera_skip_missing_${isa} PRIVATE TESSERA_TEST_ISA="${isa}")
    target_include_directories(tessera_skip_missing_${isa} PRIVATE ${CMAKE_SOURCE_DIR}/worker)
    target_link_libraries(tessera_skip_missing_${isa} PRIVATE tessera_options)

    # The same with GoogleTest, and main().
    add_library(tessera_kernel_test_main_${isa} OBJECT
      ${CMAKE_SOURCE_DIR}/tests/support/kernel/kernel_main.cpp)
    target_link_libraries(tessera_kernel_test_main_${isa} PUBLIC ${name} tessera_processor GTest::gmock
      GTest::gtest)
    target_include_directories(tessera_kernel_test_main_${isa} PRIVATE ${CMAKE_SOURCE_DIR}/tests)
    target_precompile_headers(tessera_kernel_test_main_${isa} PRIVATE
      ${CMAKE_SOURCE_DIR}/worker/render/core/wide.h
      <gtest/gtest.h>)
  endif()
endforeach()

# tessera_kernel_objects(FOLDER SOURCES... [SPECTRAL SOURCES...]): object libraries tessera_FOLDER_kernel_<isa>;
# and of the sources behind SPECTRAL tessera_FOLDER_spectral_<isa>, compiled for light of wavelengths
# (worker/render/color/spectra.h).
function(tessera_kernel_objects folder)
  cmake_parse_arguments(arg "" "" "SPECTRAL" ${ARGN})
  foreach(isa ${TESSERA_ISAS})
    foreach(kind kernel spectral)
      if(kind STREQUAL "kernel")
        set(sources ${arg_UNPARSED_ARGUMENTS})
      else()
        set(sources ${arg_SPECTRAL})
      endif()
      if(NOT sources)
        continue()
      endif()
      set(name tessera_${folder}_${kind}_${isa})
      add_library(${name} OBJECT ${sources})
      target_link_libraries(${name} PUBLIC tessera_wide_kernel_${isa})
      target_precompile_headers(${name} REUSE_FROM tessera_wide_kernel_${isa})
      if(kind STREQUAL "spectral")
        target_compile_definitions(${name} PRIVATE TESSERA_SPECTRAL)
      endif()
    endforeach()
  endforeach()
endfunction()

# tessera_kernel_test_program(NAME [SOURCES...] [SPECTRAL] KERNELS folders... [DEPENDS targets...]): one program
# an ISA, NAME_<isa>, without any entry; with SPECTRAL for light of wavelengths, where folders know of it.
function(tessera_kernel_test_program name)
  cmake_parse_arguments(arg "SPECTRAL" "" "KERNELS;DEPENDS" ${ARGN})
  foreach(isa ${TESSERA_ISAS})
    set(program ${name}_${isa})
    add_executable(${program} ${arg_UNPARSED_ARGUMENTS})
    target_include_directories(${program} PRIVATE ${CMAKE_SOURCE_DIR}/tests)
    # -fPIC, as the precompiled header, not -fPIE
    set_target_properties(${program} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
    target_compile_options(${program} PRIVATE -fPIC)
    target_link_libraries(${program} PRIVATE tessera_kernel_test_main_${isa} tessera_skip_missing_${isa})
    target_precompile_headers(${program} REUSE_FROM tessera_kernel_test_main_${isa})
    tessera_in_batches(${program})
    foreach(kernel ${arg_KERNELS})
      if(arg_SPECTRAL AND TARGET tessera_${kernel}_spectral_${isa})
        target_link_libraries(${program} PRIVATE tessera_${kernel}_spectral_${isa})
      endif()
      # Of colours, which know no light, both have parts.
      if(NOT arg_SPECTRAL OR NOT TARGET tessera_${kernel}_spectral_${isa} OR kernel STREQUAL "color")
        target_link_libraries(${program} PRIVATE tessera_${kernel}_kernel_${isa})
      endif()
    endforeach()
    if(arg_SPECTRAL)
      target_compile_definitions(${program} PRIVATE TESSERA_SPECTRAL)
    endif()
    target_link_libraries(${program} PRIVATE ${arg_DEPENDS})
    set_target_properties(${program} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  endforeach()
endfunction()

# tessera_kernel_test(NAME SOURCES... KERNELS folders... [DEPENDS targets...] | IN program [LABELS ...]
# [TIMEOUT s] [LONG s]): one ctest entry an ISA, NAME_<isa>; on a machine without the ISA it is skipped (exit
# code 77, see tests/support/kernel/skip_missing_isa.cpp). The long form is for the first.
function(tessera_kernel_test name)
  cmake_parse_arguments(arg "" "IN;TIMEOUT;LONG" "KERNELS;DEPENDS;LABELS" ${ARGN})
  if(arg_IN)
    tessera_tests_of("${arg_UNPARSED_ARGUMENTS}" sources)
  else()
    tessera_kernel_test_program(${name} ${arg_UNPARSED_ARGUMENTS} KERNELS ${arg_KERNELS} DEPENDS
      ${arg_DEPENDS})
    set(arg_IN ${name})
    set(sources)
  endif()
  set(long "${arg_LONG}")
  foreach(isa ${TESSERA_ISAS})
    if(sources)
      target_sources(${arg_IN}_${isa} PRIVATE ${arg_UNPARSED_ARGUMENTS})
    endif()
    tessera_test_entry(${name}_${isa} COMMAND ${arg_IN}_${isa} ${sources} TIMEOUT "${arg_TIMEOUT}" LONG
      "${long}" LABELS ${arg_LABELS})
    set(long)
  endforeach()
endfunction()
