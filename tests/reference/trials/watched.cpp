#include "tests/reference/trials/watched.h"

#include <fmt/format.h>

#include <sstream>
#include <stdexcept>

#include "compiler/front/body.h"
#include "runtime/ask/facts/local_facts.h"
#include "runtime/ask/query/solver.h"
#include "runtime/engine/tuple/value_text.h"

namespace meld::reference {

namespace {

// A body that holds in more ways than these is no longer asked: it would be most of a campaign's time.
constexpr std::uint64_t kMostWays = 20'000;

}  // namespace

Watched::Watched(const ModuleInfo& module, const std::string& body, bool asks) : body_(body), asks_(asks) {
    out_ = open_memstream(&text_, &size_);
    if (out_ == nullptr) throw std::runtime_error("no memory for what a watch tells");
    front::WatchRule rule{.verb = front::WatchRule::Verb::Tell, .name = "w", .asked = {.text = body}, .body = body};
    if (auto made = inspect::Watches::make(module, {std::move(rule)}, out_)) watches_ = std::move(*made);
    if (!watches_ || !asks_) return;
    if (Result<inspect::Program> program = inspect::Program::read(module, body)) program_.emplace(std::move(*program));
}

Watched::~Watched() {
    std::fclose(out_);
    std::free(text_);
}

std::optional<std::set<std::string>> Watched::ways(sim::Subdomain& subdomain) const {
    const check::Rule& question = program_->question();
    const std::vector<check::VariableId> variables = front::answers(question);
    inspect::LocalFacts facts(subdomain);
    inspect::Terms terms(*program_, subdomain.view());
    std::set<std::string> all;
    std::uint64_t count = 0;
    const auto note = [&](const inspect::Solution& found) {
        if (++count > kMostWays) return false;
        std::string text;
        for (const check::VariableId v : variables) {
            const tuple::Type type = terms.types.of(question.variables[v].type);
            text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", question.variables[v].name,
                                tuple::print_value(type, tuple::normal(type.kind(), found.values[v.index()])));
        }
        all.insert(text);
        return true;
    };
    const auto ended = inspect::Solver(*program_, facts, terms).search(question, question.body, {}, {}, note);
    if (count > kMostWays) return std::nullopt;
    if (!ended) throw std::runtime_error("interrupted");
    return all;
}

std::string Watched::after(sim::Subdomain& subdomain) {
    if (!watches_) return "";
    if (auto done = watches_->after(subdomain); !done) return "watch: " + done.error().message();
    if (!program_) return "";
    const std::optional<std::set<std::string>> now = ways(subdomain);
    if (!now) {
        program_.reset();
        return "";
    }
    std::set<std::string> expected, found;
    for (const std::string& way : *now)
        if (!before_.contains(way)) expected.insert(fmt::format("tick {}: w{}{}", subdomain.tick(), way.empty() ? "" : ": ", way));
    before_ = *now;
    const std::string text = told();
    std::istringstream lines(text.substr(seen_));
    seen_ = text.size();
    for (std::string line; std::getline(lines, line); ++lines_) found.insert(line);
    if (found == expected) return "";
    std::string trouble =
        fmt::format("watch: `{}` in tick {}: {} lines instead of {}\n", body_, subdomain.tick(), found.size(), expected.size());
    for (const std::string& line : expected)
        if (!found.contains(line)) trouble += "  missing: " + line + "\n";
    for (const std::string& line : found)
        if (!expected.contains(line)) trouble += "  not so: " + line + "\n";
    return trouble;
}

std::string Watched::told() {
    std::fflush(out_);
    return {text_, size_};
}

}  // namespace meld::reference
