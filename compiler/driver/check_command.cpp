// Every program is checked, whatever is wrong with the earlier ones, and each for itself: the cost is the sum of theirs.
#include "compiler/driver/check_command.h"

#include <algorithm>
#include <iostream>
#include <optional>
#include <set>
#include <tuple>

#include "compiler/diagnostics/most_severe.h"
#include "compiler/driver/apply_fixes.h"
#include "runtime/base/terminal/terminal_text.h"

namespace meld::driver {

using diagnostics::Diagnostic;

namespace {

class Check {
  public:
    explicit Check(const CheckOptions& options) : options_(options) {}

    int run() {
        int worst = 0;
        for (const std::string& path : options_.files) worst = std::max(worst, one(path));
        if (options_.json && read_ > 0) std::cout << json_.text() << "\n";
        if (!options_.json && options_.files.size() > 1) std::cerr << summary();
        return worst;
    }

  private:
    int one(const std::string& path) {
        Compilation c;
        CompileOptions options = options_.compile;
        options.last = Stage::Plan;
        if (const auto done = compile(path, options, c); !done) return fail_with(done.error());
        ++read_;
        std::vector<Diagnostic> messages;
        for (Diagnostic& message : c.report.sorted())
            if (is_new(c.files, message)) messages.push_back(std::move(message));
        if (options_.json) {
            json_.add(c.files, messages);
        } else {
            if (any_ && !messages.empty()) std::cerr << "\n";
            any_ = any_ || !messages.empty();
            show_messages(c.files, messages, path, options_.how_many);
        }
        counts_.add(messages);
        if (c.report.has_errors()) {
            ++wrong_;
            return static_cast<int>(ExitCode::ProgramWrong);
        }
        if (!options_.json && options_.files.size() == 1) std::cerr << visible(path) << ": no errors\n";
        return 0;
    }

    // Several programs may include one file.
    bool is_new(const source::FileSet& files, const Diagnostic& message) {
        if (options_.files.size() == 1) return true;
        const std::string& path = files.file(message.span).path();
        return seen_.emplace(path, message.span.begin, message.span.end, message.kind, message.message).second;
    }

    // "3 programs, 1 with errors: 2 errors and 1 warning".
    std::string summary() const {
        const std::size_t unread = options_.files.size() - read_;
        std::string text = fmt::format("{}{} programs", any_ ? "\n" : "", options_.files.size());
        if (wrong_ > 0) text += fmt::format(", {} with errors", wrong_);
        if (unread > 0) text += fmt::format(", {} not read", unread);
        const std::string counted = counts_.in_words();
        if (wrong_ == 0) text += unread > 0 ? ": no errors in the others" : ": no errors";
        if (!counted.empty()) text += (wrong_ > 0 ? ": " : ", ") + counted;
        return text + "\n";
    }

    const CheckOptions& options_;
    diagnostics::JsonMessages json_;
    diagnostics::Counts counts_;
    std::set<std::tuple<std::string, std::uint32_t, std::uint32_t, diagnostics::Kind, std::string>> seen_;
    std::size_t read_ = 0, wrong_ = 0;
    bool any_ = false;
};

}  // namespace

int run_check(const CheckOptions& options) {
    if (options.fix)
        if (const auto fixed = apply_fixes(options.files, options.compile); !fixed) return fail_with(fixed.error());
    return Check(options).run();
}

}  // namespace meld::driver
