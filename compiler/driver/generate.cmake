# The prelude, the libraries and the headers of emitted code, embedded in meldc.
set(embedded ${CMAKE_BINARY_DIR}/generated/compiler/driver/embedded.cpp)
set(embedded_prelude ${CMAKE_SOURCE_DIR}/stdlib/prelude.meld)
set(embedded_extern ${CMAKE_SOURCE_DIR}/runtime/abi/extern.h)
file(GLOB embedded_headers CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/runtime/kernel/*.h)
list(APPEND embedded_headers
  ${CMAKE_SOURCE_DIR}/runtime/abi/geometry_abi.h
  ${CMAKE_SOURCE_DIR}/runtime/abi/storage_abi.h
  ${CMAKE_SOURCE_DIR}/runtime/abi/module_abi.h)
file(GLOB embedded_libraries CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/stdlib/*.meld)
list(REMOVE_ITEM embedded_libraries ${embedded_prelude})
list(JOIN embedded_headers "," embedded_headers_text)
list(JOIN embedded_libraries "," embedded_libraries_text)
add_custom_command(
  OUTPUT ${embedded}
  COMMAND ${CMAKE_COMMAND} -DOUT=${embedded} -DROOT=${CMAKE_SOURCE_DIR} -DPRELUDE=${embedded_prelude} -DEXTERN=${embedded_extern}
    -DLIBRARIES=${embedded_libraries_text} -DHEADERS=${embedded_headers_text} -P ${CMAKE_SOURCE_DIR}/cmake/EmbedFiles.cmake
  DEPENDS ${embedded_prelude} ${embedded_extern} ${embedded_headers} ${embedded_libraries} ${CMAKE_SOURCE_DIR}/cmake/EmbedFiles.cmake
  VERBATIM)
list(APPEND generated ${embedded})
