// The table of kinds and the collector of diagnostics.
#include "compiler/diagnostics/diagnostics.h"

#include <algorithm>
#include <array>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::diagnostics {

namespace {

constexpr std::array kKinds = {
#define MELD_KIND(name, code, severity, title) KindInfo{#name, code, Severity::severity, title},
#include "compiler/diagnostics/kinds.def"
#undef MELD_KIND
};

std::tuple<Kind, std::uint32_t, std::uint32_t, std::uint32_t> identity(const Diagnostic& diagnostic) {
    return {diagnostic.kind, diagnostic.span.file, diagnostic.span.begin, diagnostic.span.end};
}

}  // namespace

std::string_view severity_name(Severity severity) {
    return severity == Severity::Error ? "error" : severity == Severity::Warning ? "warning" : "note";
}

const KindInfo& info(Kind kind) {
    const auto index = static_cast<std::size_t>(kind);
    MELD_EXPECT(index < kKinds.size());
    return kKinds[index];
}

const KindInfo* find_kind(std::string_view code) {
    const auto found =
        std::find_if(kKinds.begin(), kKinds.end(), [&](const KindInfo& row) { return row.code == code || row.name == code; });
    return found == kKinds.end() ? nullptr : &*found;
}

std::vector<KindInfo> all_kinds() { return {kKinds.begin(), kKinds.end()}; }

void Diagnostic::did_you_mean(const std::string& name, Span written, Edit::Fit fit) {
    help = fmt::format("did you mean `{}`?", name);
    fixes.push_back(write(written, name, fit));
}

Diagnostic& Reporter::add(Diagnostic diagnostic) {
    diagnostics_.push_back(std::move(diagnostic));
    const bool is_new = seen_.insert(identity(diagnostics_.back())).second;
    if (is_new && info(diagnostics_.back().kind).severity == Severity::Error) ++error_count_;
    return diagnostics_.back();
}

std::vector<Diagnostic> Reporter::sorted() const {
    std::vector<const Diagnostic*> order;
    std::set<std::tuple<Kind, std::uint32_t, std::uint32_t, std::uint32_t>> taken;
    for (const Diagnostic& diagnostic : diagnostics_) {
        if (taken.insert(identity(diagnostic)).second) order.push_back(&diagnostic);
    }
    // At one place in the order they were found in.
    std::stable_sort(order.begin(), order.end(), [](const Diagnostic* a, const Diagnostic* b) {
        return std::tuple(a->span.file, a->span.begin) < std::tuple(b->span.file, b->span.begin);
    });
    std::vector<Diagnostic> result;
    result.reserve(order.size());
    for (const Diagnostic* diagnostic : order) result.push_back(*diagnostic);
    return result;
}

}  // namespace meld::diagnostics
