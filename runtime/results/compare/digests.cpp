// Digest files: a line `tick N DIGEST` each, in the order of ticks.
#include <fmt/format.h>

#include <charconv>
#include <string_view>

#include "runtime/base/files/line_reader.h"
#include "runtime/results/compare/compare.h"

namespace meld::compare {

namespace {

struct Line {
    std::int64_t tick = 0;
    std::string digest;
};

class DigestLines {
  public:
    explicit DigestLines(const std::string& path) : lines_(path) {}

    // False after the last.
    Result<bool> next(Line& line) {
        if (!lines_.next(text_)) return lines_.outcome().map([] { return false; });
        constexpr std::string_view key = "tick ";
        std::int64_t tick = 0;
        const char *const begin = text_.data() + std::min(key.size(), text_.size()), *const end = text_.data() + text_.size();
        const auto read = std::from_chars(begin, end, tick);
        // The last line of a run that was killed may lack its end.
        const bool whole = lines_.ended() && text_.starts_with(key) && read.ec == std::errc{} && read.ptr != end && *read.ptr == ' ';
        if (!whole || (lines_.number() > 1 && tick <= line.tick))
            return fail(fmt::format("{}:{}: this is no digest of a tick after the one before", lines_.path(), lines_.number()),
                        "Give what `meldsim run --digest` has written");
        line = {tick, std::string(read.ptr + 1, end)};
        return true;
    }

  private:
    LineReader lines_;
    std::string text_;
};

}  // namespace

Result<Report> compare_digests(const std::string& path_a, const std::string& path_b, Progress& progress) {
    Report report{.kind = "digests"};
    DigestLines in_a(path_a), in_b(path_b);
    Line a, b;
    Result<bool> has_a = in_a.next(a), has_b = in_b.next(b);
    while (has_a && has_b && (*has_a || *has_b)) {
        progress.update([&] { return fmt::format("tick {}", *has_a ? a.tick : b.tick); });
        const bool first = *has_a && (!*has_b || a.tick <= b.tick), second = *has_b && (!*has_a || b.tick <= a.tick);
        if (first && second && !report.tick) {
            if (a.digest == b.digest)
                ++report.same_ticks;
            else
                report.tick = a.tick, report.here = {{"digest", {a.digest}, {b.digest}}};
        }
        if (first && !second) report.lone_a.add(a.tick);
        if (second && !first) report.lone_b.add(b.tick);
        if (first) has_a = in_a.next(a);
        if (second) has_b = in_b.next(b);
    }
    for (const Result<bool>* each : {&has_a, &has_b})
        if (!*each) return tl::unexpected(each->error());
    return report;
}

}  // namespace meld::compare
