# How a layer, a program and a test of this project are built. One function each, so that a folder needs no
# CMakeLists.txt of its own and the whole graph can be read in the top-level file.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE RelWithDebInfo CACHE STRING "" FORCE)
endif()
set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O2 -g1")

option(CLAYMELD_ASSERTIONS "Check MELD_EXPECT, MELD_ASSERT and MELD_ENSURE at run time" OFF)
set(CLAYMELD_SANITIZE "" CACHE STRING "Sanitizers, as -fsanitize= takes them: address,undefined or thread")

add_library(meld_flags INTERFACE)
target_compile_options(meld_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -ffp-contract=off)
target_include_directories(meld_flags INTERFACE ${CMAKE_SOURCE_DIR} ${CMAKE_BINARY_DIR}/generated)
if(CLAYMELD_ASSERTIONS)
  target_compile_definitions(meld_flags INTERFACE CLAYMELD_ASSERTIONS=1)
endif()
if(CLAYMELD_SANITIZE)
  add_compile_options(-fsanitize=${CLAYMELD_SANITIZE} -fno-omit-frame-pointer)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    # Clang reads what it knows of a function from the bytes before it. A module has none, and may begin where nothing is.
    add_compile_options(-fno-sanitize=function)
  endif()
  add_link_options(-fsanitize=${CLAYMELD_SANITIZE})
endif()
# How much memory there is for each core, MiB.
cmake_host_system_information(RESULT memory_mib QUERY TOTAL_PHYSICAL_MEMORY)
cmake_host_system_information(RESULT cores QUERY NUMBER_OF_LOGICAL_CORES)
math(EXPR memory_mib "${memory_mib} / ${cores}")
# GCC collects garbage when it has 128 MiB of it, again and again, which takes a tenth of its time. Where each core has memory enough,
# it begins at a gigabyte.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  if(memory_mib GREATER_EQUAL 1800)
    add_compile_options("SHELL:--param ggc-min-heapsize=1048576")
  endif()
endif()
# The linker gold, which comes with ld, takes half its time.
include(CheckLinkerFlag)
check_linker_flag(CXX -fuse-ld=gold CLAYMELD_HAS_GOLD)
if(CLAYMELD_HAS_GOLD AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND NOT CLAYMELD_SANITIZE)
  add_link_options(-fuse-ld=gold)
endif()
option(CLAYMELD_FUZZ "Build the libFuzzer targets too; needs Clang" OFF)
if(CLAYMELD_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()
find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
endif()

# The headers that most files include, compiled once for libraries and once for tests: the build takes half as long. Every file
# still includes what it uses; CLAYMELD_PRECOMPILE=OFF builds without, as the sanitized builds do.
option(CLAYMELD_PRECOMPILE "Compile common headers once" ON)
if(CLAYMELD_PRECOMPILE)
  set(common_headers <algorithm> <array> <cstdint> <cstring> <functional> <map> <memory> <optional> <set> <span> <string>
    <string_view> <tuple> <utility> <variant> <vector> <fmt/format.h> <tl/expected.hpp>)
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/generated/precompiled.cpp CONTENT "int main() {}\n")
  add_library(meld_precompiled STATIC ${CMAKE_BINARY_DIR}/generated/precompiled.cpp)
  target_link_libraries(meld_precompiled PRIVATE meld_flags fmt::fmt)
  target_precompile_headers(meld_precompiled PRIVATE ${common_headers})
  if(NOT CLAYMELD_PROGRAMS_ONLY)
    # Programs are compiled with -fPIE instead of -fPIC, which needs a header of its own.
    add_executable(meld_precompiled_test EXCLUDE_FROM_ALL ${CMAKE_BINARY_DIR}/generated/precompiled.cpp)
    target_link_libraries(meld_precompiled_test PRIVATE meld_flags fmt::fmt GTest::gtest)
    target_precompile_headers(meld_precompiled_test PRIVATE ${common_headers} <gtest/gtest.h>)
  endif()
  # GCC 12 takes the move of a short string for an access beyond its end where the library comes from such a header.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    add_compile_options(-Wno-array-bounds -Wno-stringop-overflow -Wno-restrict)
  endif()
endif()

# meld_precompile(TARGET FROM): lets a target use a precompiled header. Its options must be those of meld_flags.
function(meld_precompile target from)
  if(CLAYMELD_PRECOMPILE)
    target_precompile_headers(${target} REUSE_FROM ${from})
  endif()
endfunction()

# Several sources in one unit of compilation: the headers that they share are read once. The release is built so; to change the
# sources, `cmake --preset dev` builds each by itself.
option(CLAYMELD_UNITY "Compile sources of a folder together" OFF)
# Thirty sources take up to 2.5 GiB of memory, ten half of that.
set(unity_size 10)
if(memory_mib GREATER_EQUAL 3500)
  set(unity_size 30)
endif()
set(CLAYMELD_UNITY_SIZE ${unity_size} CACHE STRING "How many sources are compiled together; 0: all of a library")
function(meld_unite target)
  if(CLAYMELD_UNITY)
    # Sources that name classes of CLI11 come first, and so together: its header takes four seconds.
    get_target_property(sources ${target} SOURCES)
    set(of_command_lines "")
    foreach(source ${sources})
      if(EXISTS ${source})
        file(STRINGS ${source} found REGEX "CLI::" LIMIT_COUNT 1)
        if(found)
          list(APPEND of_command_lines ${source})
        endif()
      endif()
    endforeach()
    if(of_command_lines)
      list(REMOVE_ITEM sources ${of_command_lines})
      set_target_properties(${target} PROPERTIES SOURCES "${of_command_lines};${sources}")
    endif()
    # GCC warns of private types in classes that a source defines for itself: it takes them for those of a header.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${CLAYMELD_UNITY_SIZE})
  endif()
endfunction()

# Code that no tick runs is optimised less, and compiled in less time. At -O1 alone GCC clears an array byte by byte, as the parser
# does with each symbol.
function(meld_optimise_less target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:RelWithDebInfo>:-O1>
    $<$<AND:$<CONFIG:RelWithDebInfo>,$<CXX_COMPILER_ID:GNU>>:-ftree-loop-distribute-patterns>)
endfunction()

function(meld_target_name folder result)
  string(REPLACE "/" "_" name ${folder})
  set(${result} ${name} PARENT_SCOPE)
endfunction()

# meld_embed(FOLDER TEXT name file [TABLE name files ...]): in a generate.cmake, adds to its layer a source with the texts of these files.
function(meld_embed folder)
  cmake_parse_arguments(ARG "" "" "TEXT;TABLE" ${ARGN})
  list(POP_FRONT ARG_TEXT text_name)
  set(table_name "")
  if(ARG_TABLE)
    list(POP_FRONT ARG_TABLE table_name)
  endif()
  list(JOIN ARG_TABLE "," files)
  set(out ${CMAKE_BINARY_DIR}/generated/${folder}/embedded.cpp)
  set(script ${CMAKE_SOURCE_DIR}/cmake/EmbedFiles.cmake)
  add_custom_command(
    OUTPUT ${out}
    COMMAND ${CMAKE_COMMAND} -DOUT=${out} -DROOT=${CMAKE_SOURCE_DIR} -DFOLDER=${folder} -DTEXT=${text_name} -DFILE=${ARG_TEXT}
      -DTABLE=${table_name} -DFILES=${files} -P ${script}
    DEPENDS ${ARG_TEXT} ${ARG_TABLE} ${script}
    VERBATIM)
  set(generated ${generated} ${out} PARENT_SCOPE)
endfunction()

# meld_layer(FOLDER [OUTSIDE_TICKS] [ROOMS subfolders ...] [VIEWER sources ...] [MODELS sources ...] DEPENDS ...): the library made of all
# sources directly in FOLDER and its rooms, except main.cpp. Dependencies that name a folder are layers, the others are CMake targets.
# VIEWER names the sources that call what is optional: with CLAYMELD_VIEWER=OFF those in FOLDER/without stand in their place. MODELS does
# the same.
function(meld_layer folder)
  cmake_parse_arguments(ARG "OUTSIDE_TICKS" "" "ROOMS;VIEWER;MODELS;DEPENDS" ${ARGN})
  meld_target_name(${folder} name)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${folder}/*.cpp)
  foreach(room ${ARG_ROOMS})
    file(GLOB room_sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${folder}/${room}/*.cpp)
    list(APPEND sources ${room_sources})
  endforeach()
  list(FILTER sources EXCLUDE REGEX "/main\\.cpp$")
  foreach(part VIEWER MODELS)
    if(ARG_${part} AND NOT CLAYMELD_${part})
      list(TRANSFORM ARG_${part} PREPEND ${CMAKE_SOURCE_DIR}/${folder}/)
      list(REMOVE_ITEM sources ${ARG_${part}})
      file(GLOB instead CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${folder}/without/*.cpp)
      list(APPEND sources ${instead})
    endif()
  endforeach()
  if(EXISTS ${CMAKE_SOURCE_DIR}/${folder}/generate.cmake)
    set(generated "")
    include(${CMAKE_SOURCE_DIR}/${folder}/generate.cmake)
    list(APPEND sources ${generated})
  endif()
  set(library ${name})
  # A layer with an optional part stays by itself, so that no other library differs without it.
  if(meld_neighbourhood_outside_ticks)
    set(ARG_OUTSIDE_TICKS ON)
  endif()
  if(CLAYMELD_UNITY AND meld_neighbourhood AND sources AND NOT ARG_VIEWER AND NOT ARG_MODELS
      AND (meld_neighbourhood_outside_ticks OR NOT ARG_OUTSIDE_TICKS))
    set(library ${meld_neighbourhood}_together)
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE ${library})
  endif()
  set(scope PUBLIC)
  if(NOT sources)
    add_library(${name} INTERFACE)
    set(scope INTERFACE)
  elseif(TARGET ${library})
    target_sources(${library} PRIVATE ${sources})
  else()
    add_library(${library} STATIC ${sources})
    meld_unite(${library})
    if(ARG_OUTSIDE_TICKS)
      meld_optimise_less(${library})
    endif()
    if(NOT folder MATCHES "^physics")
      meld_precompile(${library} meld_precompiled)
    endif()
  endif()
  set_target_properties(${name} PROPERTIES MELD_LIBRARY ${library})
  target_link_libraries(${library} ${scope} meld_flags)
  foreach(dependency ${ARG_DEPENDS})
    if(IS_DIRECTORY ${CMAKE_SOURCE_DIR}/${dependency})
      meld_target_name(${dependency} dependency)
      get_target_property(of_dependency ${dependency} MELD_LIBRARY)
      if(of_dependency STREQUAL library)
        continue()
      endif()
    endif()
    target_link_libraries(${library} ${scope} ${dependency})
  endforeach()
endfunction()

# meld_neighbourhood(NAME [OUTSIDE_TICKS]): the layers from here to the next call are one library where sources are compiled together, but
# for those with optional parts and, unless all are, those outside of ticks. NAME may be empty.
function(meld_neighbourhood name)
  cmake_parse_arguments(ARG "OUTSIDE_TICKS" "" "" ${ARGN})
  set(meld_neighbourhood "${name}" PARENT_SCOPE)
  set(meld_neighbourhood_outside_ticks ${ARG_OUTSIDE_TICKS} PARENT_SCOPE)
endfunction()

# meld_plugin(NAME FOLDER DEPENDS targets ...): the shared library lib/claymeld/libNAME.so from FOLDER, opened at run time and never
# linked. The target NAME is what its user depends on, so that both are built together.
function(meld_plugin name folder)
  cmake_parse_arguments(ARG "" "" "DEPENDS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${folder}/*.cpp)
  add_library(${name}_library MODULE ${sources})
  meld_unite(${name}_library)
  target_link_libraries(${name}_library PRIVATE meld_flags ${ARG_DEPENDS})
  set_target_properties(${name}_library PROPERTIES OUTPUT_NAME ${name} LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib/claymeld)
  add_library(${name} INTERFACE)
  add_dependencies(${name} ${name}_library)
endfunction()

# meld_program(NAME FOLDER): the executable NAME from FOLDER/main.cpp and the layer FOLDER.
function(meld_program name folder)
  meld_target_name(${folder} layer)
  if(EXISTS ${CMAKE_SOURCE_DIR}/${folder}/main.cpp)
    add_executable(${name} ${CMAKE_SOURCE_DIR}/${folder}/main.cpp)
    meld_optimise_less(${name})
    target_link_libraries(${name} PRIVATE ${layer})
  endif()
endfunction()

# meld_test(NAME [COMPUTES] SOURCES ... DEPENDS layer folders ...): a GoogleTest program run by ctest, part of the target unit_tests. One
# that computes for long by itself is optimised as programs are.
function(meld_test name)
  cmake_parse_arguments(ARG "COMPUTES" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  meld_unite(${name})
  if(NOT ARG_COMPUTES)
    meld_optimise_less(${name})
  endif()
  meld_precompile(${name} meld_precompiled_test)
  foreach(dependency ${ARG_DEPENDS})
    if(IS_DIRECTORY ${CMAKE_SOURCE_DIR}/${dependency})
      meld_target_name(${dependency} dependency)
    endif()
    target_link_libraries(${name} PRIVATE ${dependency})
  endforeach()
  target_link_libraries(${name} PRIVATE GTest::gtest_main GTest::gmock)
  add_dependencies(unit_tests ${name})
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES TIMEOUT 600)
endfunction()
