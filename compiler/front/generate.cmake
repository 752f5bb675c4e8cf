# The prelude and the libraries, embedded in every program that reads Meld.
set(embedded_prelude ${CMAKE_SOURCE_DIR}/stdlib/prelude.meld)
file(GLOB embedded_libraries CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/stdlib/*.meld)
list(REMOVE_ITEM embedded_libraries ${embedded_prelude})
meld_embed(compiler/front TEXT kPrelude ${embedded_prelude} TABLE kLibraries ${embedded_libraries})
