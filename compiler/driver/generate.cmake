# The headers of emitted code, embedded in meldc.
file(GLOB embedded_headers CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/runtime/module/kernel/*.h)
list(APPEND embedded_headers
  ${CMAKE_SOURCE_DIR}/runtime/module/abi/counts_abi.h
  ${CMAKE_SOURCE_DIR}/runtime/module/abi/geometry_abi.h
  ${CMAKE_SOURCE_DIR}/runtime/module/abi/storage_abi.h
  ${CMAKE_SOURCE_DIR}/runtime/module/abi/module_abi.h)
meld_embed(compiler/driver TEXT kExtern ${CMAKE_SOURCE_DIR}/runtime/module/abi/extern.h TABLE kModuleHeaders ${embedded_headers})
