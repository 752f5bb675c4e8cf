#include "compiler/driver/show_messages.h"

#include <unistd.h>

#include <iostream>

#include "compiler/diagnostics/most_severe.h"
#include "runtime/base/terminal/terminal_text.h"

namespace meld::driver {

namespace {

// A screen or two: readers begin at the end, and curing the first mistakes often cures the rest.
constexpr std::size_t kMostMessages = 50;

}  // namespace

void show_messages(const source::FileSet& files, const std::vector<diagnostics::Diagnostic>& messages, const std::string& path,
                   HowMany how_many) {
    const auto colour = isatty(STDERR_FILENO) ? diagnostics::Colour::Always : diagnostics::Colour::Never;
    const bool some = how_many == HowMany::MostSevere && messages.size() > kMostMessages;
    std::cerr << diagnostics::render_text(files, some ? diagnostics::most_severe(messages, kMostMessages) : messages, colour);
    if (some)
        std::cerr << fmt::format("\n{} in all; {} are shown, and `meldc check {} --all` shows the others\n",
                                 diagnostics::count_in_words(messages), kMostMessages, path);
}

int fail_with(const Error& error) {
    std::cerr << "meldc: " << visible(error.message()) << "\n";
    return static_cast<int>(error.code);
}

}  // namespace meld::driver
