// meldc-lsp: the language server. `meldc lsp` starts it; it is a program of its own because LLVM's libraries take long to load.
#include <cstdio>
#include <cstring>
#include <iostream>

#include "compiler/lsp/server.h"

int main(int argc, char** argv) {
    if (argc > 1 && std::strcmp(argv[1], "--help") == 0) {
        std::cout
            << "meldc-lsp speaks the Language Server Protocol over standard input and output. Editors start it through `meldc lsp`.\n";
        return 0;
    }
    return meld::lsp::serve(stdin, stdout);
}
