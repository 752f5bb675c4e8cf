// The entry of the library.
#include "compiler/build/backend/backend.h"

#include "compiler/build/backend/compile_extern.h"
#include "compiler/build/backend/compile_object.h"
#include "compiler/build/backend/compile_piece.h"
#include "compiler/build/backend/link_module.h"

const meld::Backend* meld_backend() {
    static constexpr meld::Backend backend = {.compile_object = &meld::compile_object,
                                              .compile_shared = &meld::compile_shared,
                                              .compile_piece = &meld::compile_piece,
                                              .compile_extern = &meld::compile_extern,
                                              .link_module = &meld::link_module};
    return &backend;
}
