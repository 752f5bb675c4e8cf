// The prelude as a file, so that an editor can show it.
#pragma once

#include <string>

namespace meld::lsp {

// The path of a file with the prelude's text in the user's cache, written if it does not exist; empty if that fails.
std::string prelude_path();

// Whether an open file is the prelude: that copy, or the one in the sources.
bool is_prelude_file(const std::string& path);

}  // namespace meld::lsp
