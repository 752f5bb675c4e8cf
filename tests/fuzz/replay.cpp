// Runs a fuzz target over files and folders, and over mutations of each: what fuzzing found stays found, with any compiler.
//     fuzz_front_end_replay PLACES...                 every file below
//     fuzz_front_end_replay --mutations N PLACES...   and N mutations of each, from fixed seeds
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/fuzz/mutate.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxBytes = 1 << 16;

void run(const std::string& text) { LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()); }

}  // namespace

int main(int argc, char** argv) {
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
