// Standard input for LLVM's JSON reader, which reads nested values by recursion: messages that nest deeper than any of the protocol arrive
// as invalid JSON, and get the same answer.
#pragma once

#include <cstdio>

namespace meld::lsp {

// A stream of the bytes of `in`. In a message whose brackets nest more than 1,000 deep, the deeper opening brackets become blanks, so it
// has as many bytes as before but is not valid JSON. Close it with fclose, which leaves `in` open; null if there is no memory for it.
std::FILE* open_shallow(std::FILE* in);

}  // namespace meld::lsp
