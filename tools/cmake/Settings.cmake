# How everything is compiled. Contraction is off: the same source gives the same forces at -O2 and -O3.
include(GNUInstallDirs)
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_C_STANDARD 11)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_CXX_SCAN_FOR_MODULES OFF)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")
if(HAPTICD_SANITIZE MATCHES "address")
  # Checks at every access leave the optimizer little to do and take two thirds of the compiler's time: only what computes for long has it
  # (hapticd_computes).
  set(CMAKE_CXX_FLAGS_RELEASE "-O0 -DNDEBUG")
elseif(HAPTICD_SANITIZE)
  set(CMAKE_CXX_FLAGS_RELEASE "-O1 -DNDEBUG")  # A quarter less of g++ than with -O2, for tests that mostly wait.
endif()

# Programs in any other folder find the library beside them; Debian's packages need no such path and may not have one.
if(NOT CMAKE_INSTALL_PREFIX STREQUAL "/usr")
  set(CMAKE_INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}" "$ORIGIN/../../${CMAKE_INSTALL_LIBDIR}")
endif()

# Bound when loaded: a servo's first call of a library's function must not go through the dynamic linker.
add_link_options(-Wl,-z,relro,-z,now)

# What Debian asks of its packages: programs that read what others write notice when it overruns them.
if(NOT HAPTICD_SANITIZE AND NOT HAPTICD_FUZZ)
  add_compile_options(-fstack-protector-strong $<$<CONFIG:Release>:-D_FORTIFY_SOURCE=2>)
endif()

find_program(HAPTICD_CCACHE ccache)
if(HAPTICD_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime
      CCACHE_NOHASHDIR=1 CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} ${HAPTICD_CCACHE})
  set(CMAKE_C_COMPILER_LAUNCHER ${CMAKE_CXX_COMPILER_LAUNCHER})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    add_compile_options("SHELL:$<$<COMPILE_LANGUAGE:CXX>:-Xclang -fno-pch-timestamp>")
  endif()
endif()

# Most of what a file costs is what it instantiates of libraries, the same in each: in batches that is done once for 32 files.
# A full build takes two thirds of the time or less, one change twice as long. Names in unnamed namespaces must then differ within a target
# (tests/lint/names.py).
option(HAPTICD_UNITY "Compile in batches of files" OFF)
if(HAPTICD_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # g++ looks for what it may forget whenever that could save 128 MB; with 3 GB for each of its processes it need not: 7 % of its time.
  cmake_host_system_information(RESULT memory_mb QUERY TOTAL_PHYSICAL_MEMORY)
  cmake_host_system_information(RESULT processors QUERY NUMBER_OF_LOGICAL_CORES)
  math(EXPR share_mb "${memory_mb} / (${processors} + 2)")
  if(share_mb GREATER 3000)
    add_compile_options(--param=ggc-min-heapsize=1000000)
  endif()
endif()

add_library(hapticd_settings INTERFACE)
target_include_directories(hapticd_settings INTERFACE ${PROJECT_SOURCE_DIR})
# In batches a local name may be that of another file's own.
target_compile_options(hapticd_settings INTERFACE -Wall -Wextra $<$<NOT:$<BOOL:${HAPTICD_UNITY}>>:-Wshadow> -Wno-missing-field-initializers
                       -ffp-contract=off)
if(HAPTICD_SANITIZE)
  add_compile_options(-fsanitize=${HAPTICD_SANITIZE} -fno-omit-frame-pointer -g1)
  add_link_options(-fsanitize=${HAPTICD_SANITIZE})
  if(HAPTICD_SANITIZE MATCHES "address")
    # It does not see a vector that nobody has set, as of {}; whoever takes one for zero gets no number instead.
    add_compile_definitions(EIGEN_INITIALIZE_MATRICES_BY_NAN)
  endif()
  if(HAPTICD_SANITIZE MATCHES "undefined")
    # Left to the address sanitizer, which sees each access itself: these four checks cost a third of the compiler's time, and Eigen's
    # functions their inlining.
    add_compile_options(-fno-sanitize-recover=undefined -fno-sanitize=null,object-size,pointer-overflow,vptr)
  endif()
endif()
if(HAPTICD_FUZZ)
  # What libFuzzer needs to see new paths. Comparisons are not traced: that takes twice the time, and the tests of the sanitizer
  # lane run in this build, too. For a long hunt add -DCMAKE_CXX_FLAGS=-fsanitize-coverage=trace-cmp in a folder of its own.
  add_compile_options(-fsanitize-coverage=inline-8bit-counters,pc-table)
endif()

find_package(Threads REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(PkgConfig REQUIRED)

# hapticd_sources(OUT PATTERN... [EXCEPT REGEX]): sources of a room are found, not listed, so that a new file needs no
# other edit. Configure again is automatic.
function(hapticd_sources out)
  cmake_parse_arguments(PARSE_ARGV 1 of "" EXCEPT "")
  list(TRANSFORM of_UNPARSED_ARGUMENTS PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
  file(GLOB_RECURSE found CONFIGURE_DEPENDS ${of_UNPARSED_ARGUMENTS})
  if(of_EXCEPT)
    list(FILTER found EXCLUDE REGEX ${of_EXCEPT})
  endif()
  set(${out} ${found} PARENT_SCOPE)
endfunction()

# hapticd_unity(TARGET [EXCEPT REGEX]): without files whose names would clash, or that need much memory.
function(hapticd_unity target)
  cmake_parse_arguments(PARSE_ARGV 1 of "" EXCEPT "")
  if(HAPTICD_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 32)
    # An unnamed namespace is not that of a header.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
    if(of_EXCEPT)
      get_target_property(alone ${target} SOURCES)
      list(FILTER alone INCLUDE REGEX ${of_EXCEPT})
      set_source_files_properties(${alone} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    endif()
  endif()
endfunction()

# hapticd_computes(TARGET): computes for so long that it is optimized under the address sanitizer, too.
function(hapticd_computes target)
  if(HAPTICD_SANITIZE MATCHES "address")
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  endif()
endfunction()
