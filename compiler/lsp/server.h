// The language server: open files, and an answer to every request of an editor.
#pragma once

#include <cstdio>

namespace meld::lsp {

// Serves one editor over these streams until it says `exit` or the input ends. Returns the exit code: 0 if it said `shutdown` before.
int serve(std::FILE* in, std::FILE* out);

}  // namespace meld::lsp
