// The language server: open files, and an answer to every request of an editor.
#pragma once

#include <cstdio>

namespace meld::lsp {

// Serves one editor over these streams until it sends `exit` or the input ends. Returns the exit code: 0 if it sent `shutdown` before.
int serve(std::FILE* in, std::FILE* out);

}  // namespace meld::lsp
