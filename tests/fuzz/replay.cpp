// Runs a fuzz target over files and folders, and over mutations of each: what fuzzing found stays found, with any compiler.
//     fuzz_front_end_replay PLACES...                 every file below
//     fuzz_front_end_replay --mutations N PLACES...   and N mutations of each, from fixed seeds
// A text on which the target crashes is kept in the file `crash`.
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "tests/fuzz/mutate.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxBytes = 1 << 16;

// The text at work, for the handler of signals.
const std::string* at_work = nullptr;

void run(const std::string& text) {
    at_work = &text;
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
    at_work = nullptr;
}

void keep_text(int signal) {
    if (at_work) {
        const int file = open("crash", O_WRONLY | O_CREAT | O_TRUNC, 0644);
        if (file >= 0 && write(file, at_work->data(), at_work->size()) >= 0) {
            constexpr std::string_view kMessage = "the text on which the target crashed is in the file `crash`\n";
            [[maybe_unused]] const auto written = write(STDERR_FILENO, kMessage.data(), kMessage.size());
        }
    }
    raise(signal);
}

// A stack of its own, because a deep recursion leaves none.
void handle_crashes() {
    static std::array<char, 1 << 16> room;
    stack_t stack{};
    stack.ss_sp = room.data();
    stack.ss_size = room.size();
    sigaltstack(&stack, nullptr);
    struct sigaction action{};
    action.sa_handler = keep_text;
    action.sa_flags = static_cast<int>(SA_ONSTACK | SA_RESETHAND);
    for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) sigaction(signal, &action, nullptr);
}

}  // namespace

int main(int argc, char** argv) {
    handle_crashes();
    std::vector<fs::path> files;
    unsigned mutations = 0;
    for (int i = 1; i < argc; ++i) {
        if (std::string(argv[i]) == "--mutations" && i + 1 < argc) {
            mutations = static_cast<unsigned>(std::atoi(argv[++i]));
        } else if (fs::is_directory(argv[i])) {
            for (const auto& entry : fs::recursive_directory_iterator(argv[i]))
                if (entry.is_regular_file()) files.push_back(entry.path());
        } else {
            files.emplace_back(argv[i]);
        }
    }
    std::sort(files.begin(), files.end());
    std::vector<std::string> texts;
    for (const fs::path& file : files) {
        std::ifstream stream(file, std::ios::binary);
        texts.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
    }
    for (std::size_t i = 0; i < texts.size(); ++i) {
        run(texts[i]);
        std::string text = texts[i];
        for (unsigned m = 0; m < mutations; ++m) {
            // Changes pile up for a while, so that some texts come far from any that was written.
            if (m % 8 == 0) text = texts[i];
            text = meld::fuzz::mutate(text, texts[(i + m) % texts.size()], static_cast<unsigned>(i) * 1000003u + m, kMaxBytes);
            run(text);
        }
    }
    fmt::print("{} files, {} mutations of each\n", texts.size(), mutations);
    return texts.empty() ? 1 : 0;
}
