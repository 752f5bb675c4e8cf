// meldc-lsp: the language server. `meldc lsp` starts it; it is a separate program because LLVM's libraries take long to load.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <optional>

#include "compiler/lsp/server.h"
#include "runtime/base/files/standard_streams.h"
#include "runtime/base/process/deep_stack.h"
#include "runtime/cli/command_line.h"

namespace {

int run(int argc, char** argv) {
    CLI::App app{"meldc-lsp serves an editor over standard input and output (Language Server Protocol). Editors start it with `meldc lsp`.",
                 "meldc-lsp"};
    bool over_stdio = true;
    app.add_flag("--stdio", over_stdio, "Use standard input and output, which is the only way");
    // Editors may add options of their own, such as the number of their process.
    app.allow_extras();
    meld::cli::add_common(app);
    if (const std::optional<int> code = meld::cli::parse(app, argc, argv)) return *code;
    return meld::lsp::serve(stdin, stdout);
}

}  // namespace

int main(int argc, char** argv) {
    meld::prepare_standard_streams();
    return meld::with_deep_stack("meldc-lsp", [&] { return run(argc, argv); });
}
