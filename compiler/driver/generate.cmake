# The headers of emitted code, embedded in meldc.
file(GLOB embedded_headers CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/runtime/kernel/*.h)
list(APPEND embedded_headers
  ${CMAKE_SOURCE_DIR}/runtime/abi/counts_abi.h
  ${CMAKE_SOURCE_DIR}/runtime/abi/geometry_abi.h
  ${CMAKE_SOURCE_DIR}/runtime/abi/storage_abi.h
  ${CMAKE_SOURCE_DIR}/runtime/abi/module_abi.h)
meld_embed(compiler/driver TEXT kExtern ${CMAKE_SOURCE_DIR}/runtime/abi/extern.h TABLE kModuleHeaders ${embedded_headers})
