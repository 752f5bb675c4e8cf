# The prelude, the libraries and the headers of emitted code, embedded in meldc.
set(embedded ${CMAKE_BINARY_DIR}/generated/compiler/driver/embedded.cpp)
set(embedded_names kPrelude kGeometryAbi kStorageAbi kModuleAbi kKernelValues kKernelLists kKernelLibrary kKernelExactMean
  kKernelRows kKernelAggregates kKernelViews kKernelDeltas kKernelFronts kExtern)
set(embedded_files
  ${CMAKE_SOURCE_DIR}/stdlib/prelude.meld
  ${CMAKE_SOURCE_DIR}/runtime/abi/geometry_abi.h
  ${CMAKE_SOURCE_DIR}/runtime/abi/storage_abi.h
  ${CMAKE_SOURCE_DIR}/runtime/abi/module_abi.h
  ${CMAKE_SOURCE_DIR}/runtime/kernel/values.h
  ${CMAKE_SOURCE_DIR}/runtime/kernel/lists.h
  ${CMAKE_SOURCE_DIR}/runtime/kernel/library.h
  ${CMAKE_SOURCE_DIR}/runtime/kernel/exact_mean.h
  ${CMAKE_SOURCE_DIR}/runtime/kernel/rows.h
  ${CMAKE_SOURCE_DIR}/runtime/kernel/aggregates.h
  ${CMAKE_SOURCE_DIR}/runtime/kernel/views.h
  ${CMAKE_SOURCE_DIR}/runtime/kernel/deltas.h
  ${CMAKE_SOURCE_DIR}/runtime/kernel/fronts.h
  ${CMAKE_SOURCE_DIR}/runtime/abi/extern.h)
file(GLOB embedded_libraries CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/stdlib/*.meld)
list(REMOVE_ITEM embedded_libraries ${CMAKE_SOURCE_DIR}/stdlib/prelude.meld)
list(JOIN embedded_libraries "," embedded_libraries_text)
list(JOIN embedded_names "," embedded_names_text)
list(JOIN embedded_files "," embedded_files_text)
add_custom_command(
  OUTPUT ${embedded}
  COMMAND ${CMAKE_COMMAND} -DOUT=${embedded} -DNAMES=${embedded_names_text} -DFILES=${embedded_files_text}
    -DLIBRARIES=${embedded_libraries_text} -P ${CMAKE_SOURCE_DIR}/cmake/EmbedFiles.cmake
  DEPENDS ${embedded_files} ${embedded_libraries} ${CMAKE_SOURCE_DIR}/cmake/EmbedFiles.cmake
  VERBATIM)
list(APPEND generated ${embedded})
