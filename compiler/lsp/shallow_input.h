// Standard input for LLVM's JSON reader, which reads nested values by recursion: messages nested deeper than any of the protocol
// arrive broken, and are answered as broken ones are.
#pragma once

#include <cstdio>

namespace meld::lsp {

// A stream of what `in` holds. In a message whose brackets nest more than 1,000 deep the deeper opening ones are blanks: it has as
// many bytes as before, and is no JSON. Close it with fclose, which leaves `in` open; null if there is no memory for it.
std::FILE* open_shallow(std::FILE* in);

}  // namespace meld::lsp
