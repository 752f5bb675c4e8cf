#include "runtime/driver/run/junit.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "runtime/base/terminal/terminal_text.h"

namespace meld::driver {

namespace {

// For the value of an attribute or the text of an element. Bytes that are no visible text come as \x and two digits.
std::string escaped(std::string_view text) {
    std::string out;
    for (const char c : visible(text)) switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '"':
                out += "&quot;";
                break;
            default:
                out += c;
        }
    return out;
}

}  // namespace

std::string junit(const std::string& program, const Result<void>& ran, double seconds,
                  const std::vector<inspect::Watches::Outcome>& outcomes) {
    std::size_t failures = 0, skipped = 0;
    std::string cases;
    const std::string suite = escaped(program);
    const auto begin = [&](const std::string& name, double time) {
        cases += fmt::format("    <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\"", suite, escaped(name), time);
    };
    begin("the run", seconds);
    if (ran)
        cases += "/>\n";
    else
        cases += fmt::format(">\n      <error message=\"{}\"/>\n    </testcase>\n", escaped(ran.error().message()));
    for (const inspect::Watches::Outcome& o : outcomes) {
        begin(fmt::format("{}: {}", o.verb, o.name), 0);
        if (o.wrong) {
            ++failures;
            const std::string_view found = o.found;
            const std::size_t line = std::min(found.find('\n'), found.size());
            cases += fmt::format(">\n      <failure message=\"{}\">{}</failure>\n    </testcase>\n", escaped(found.substr(0, line)),
                                 escaped(found.substr(line)));
        } else if (!ran) {
            ++skipped;
            cases += ">\n      <skipped message=\"the run did not come to its end\"/>\n    </testcase>\n";
        } else {
            cases += "/>\n";
        }
    }
    const std::string counts = fmt::format("tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\" time=\"{:.3f}\"", outcomes.size() + 1,
                                           failures, ran ? 0 : 1, skipped, seconds);
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites {}>\n  <testsuite name=\"{}\" {}>\n{}  </testsuite>\n</testsuites>\n",
        counts, suite, counts, cases);
}

}  // namespace meld::driver
