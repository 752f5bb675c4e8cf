# The CMake package `claymeld`: builds extensions of meldsim against an installed Claymeld.
#
#     find_package(claymeld REQUIRED)
#     claymeld_add_extension(NAME source.cpp ...)     # Makes NAME.so for `meldsim run --extension NAME.so`.
#
# It lies in PREFIX/lib/cmake/claymeld and finds everything else from there.
include(CMakeFindDependencyMacro)
find_dependency(fmt)
get_filename_component(CLAYMELD_PREFIX "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

if(NOT TARGET claymeld::extension)
  add_library(claymeld::extension INTERFACE IMPORTED)
  set_target_properties(claymeld::extension PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES "${CLAYMELD_PREFIX}/include/claymeld"
    INTERFACE_COMPILE_FEATURES cxx_std_20
    INTERFACE_COMPILE_OPTIONS -ffp-contract=off
    INTERFACE_COMPILE_DEFINITIONS XXH_INLINE_ALL
    INTERFACE_LINK_LIBRARIES fmt::fmt)
  add_executable(claymeld::meldsim IMPORTED)
  set_target_properties(claymeld::meldsim PROPERTIES IMPORTED_LOCATION "${CLAYMELD_PREFIX}/bin/meldsim")
  add_executable(claymeld::meldc IMPORTED)
  set_target_properties(claymeld::meldc PROPERTIES IMPORTED_LOCATION "${CLAYMELD_PREFIX}/bin/meldc")
endif()

function(claymeld_add_extension name)
  add_library(${name} MODULE ${ARGN})
  set_target_properties(${name} PROPERTIES PREFIX "" CXX_VISIBILITY_PRESET default CXX_EXTENSIONS OFF)
  target_link_libraries(${name} PRIVATE claymeld::extension)
endfunction()
