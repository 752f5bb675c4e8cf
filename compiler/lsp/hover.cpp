// Hovers: the declaration, the author's comment, the storage, and the rules that use the name.
#include <fmt/format.h>

#include <algorithm>

#include "compiler/lsp/describe.h"

namespace meld::lsp {

namespace {

// More rules than this are counted, not shown.
constexpr std::size_t kMaxRules = 8;

std::string code(const std::string& text) { return "```meld\n" + text + "\n```\n"; }

const check::Predicate* find(const Table<check::Predicate>& table, const Symbol& symbol) {
    for (const check::Predicate& predicate : table) {
        if (!predicate.auxiliary && predicate.name == symbol.name && predicate.arguments.size() == symbol.arity) return &predicate;
    }
    return nullptr;
}

// "sensed route linear fact": what the declaration says of the predicate, in words.
std::string nature(const check::Program& program, const check::Predicate& predicate) {
    std::string text =
        predicate.linear() ? "linear: a fact is consumed when it is matched" : "persistent: kept true while its support lasts";
    if (predicate.kind == check::PredicateKind::Action)
        text = predicate.repeats ? "action: carried out in every tick while it holds" : "action: carried out once, when it is derived";
    if (predicate.sensed)
        text = predicate.linear() ? "sensed: given by the runtime, consumed when it is matched" : "sensed: maintained by the runtime";
    if (predicate.route) text += "; route: its second argument is the catom it points to";
    if (predicate.aggregate == check::Aggregate::None || predicate.aggregate_at >= predicate.arguments.size()) return text;
    const std::string name = predicate.arguments[predicate.aggregate_at].name;
    return text + fmt::format("; aggregate: {}{}{}", check::aggregate_name(program, predicate), name.empty() ? "" : " of ", name);
}

std::string stored(const Analysis& analysis, const Symbol& symbol) {
    const plan::Plan* plan = analysis.plan();
    if (plan == nullptr) return "";
    for (const check::PredicateId id : plan->program.predicates.ids()) {
        const check::Predicate& predicate = plan->program.predicates[id];
        if (predicate.auxiliary || predicate.name != symbol.name || predicate.arguments.size() != symbol.arity) continue;
        const plan::Stored& how = plan->of(id);
        return fmt::format("- stored as: {}{}\n", plan::storage_name(how.storage), how.exported ? ", read at neighbours" : "");
    }
    return "";
}

std::string stratum(const Analysis& analysis, const Symbol& symbol) {
    const check::Program& program = analysis.program();
    for (std::size_t i = 0; i < program.strata.size(); ++i) {
        const check::Stratum& c = program.strata[i];
        std::vector<std::string> others;
        bool here = false;
        for (const check::PredicateId id : c.predicates) {
            const check::Predicate& predicate = program.predicates[id];
            const bool same = predicate.name == symbol.name && predicate.arguments.size() == symbol.arity;
            here = here || same;
            if (!same) others.push_back("`" + predicate.signature() + "`");
        }
        if (!here || c.rules.empty()) continue;
        std::string text = fmt::format("- stratum {} of {}: ", i + 1, program.strata.size());
        text += !c.recursive         ? "not recursive"
                : c.rounds           ? "recursive in rounds"
                : c.tree             ? "recursive, sums over a tree"
                : c.local && c.links ? "recursive at the catom and over links"
                : c.links            ? "recursive over links"
                                     : "recursive at the catom";
        if (!others.empty()) text += fmt::format(", together with {}", fmt::join(others, ", "));
        return text + "\n";
    }
    return "";
}

// The rules with an occurrence in this role.
std::string rules(const Analysis& analysis, const Symbol& symbol, Role role, const char* title) {
    std::vector<std::string> lines;
    std::size_t count = 0;
    std::pair<std::uint32_t, std::size_t> last{0, kAnyArity};
    for (const auto& [file, occurrence] : analysis.all(symbol)) {
        if (occurrence->role != role || last == std::pair(file, occurrence->item)) continue;
        last = {file, occurrence->item};
        if (++count <= kMaxRules) lines.push_back(analysis.item_text(file, occurrence->item));
    }
    if (count == 0) return "";
    std::string text = fmt::format("\n{}:\n{}", title, code(fmt::format("{}", fmt::join(lines, "\n"))));
    if (count > kMaxRules) text += fmt::format("and {} more\n", count - kMaxRules);
    return text;
}

std::string declared(const Analysis& analysis, const Symbol& symbol) {
    const auto declaration = analysis.declaration(symbol);
    if (!declaration) return "";
    const auto [file, occurrence] = *declaration;
    std::string text = code(analysis.item_text(file, occurrence->item));
    const std::string doc = analysis.doc(file, occurrence->item);
    if (!doc.empty()) text += doc + "\n\n";
    if (analysis.is_prelude(file)) text += "*From the prelude, which every program knows.*\n\n";
    return text;
}

std::string predicate(const Analysis& analysis, const Symbol& symbol) {
    std::string text = declared(analysis, symbol);
    if (text.empty()) text = fmt::format("`{}` is not declared.\n\n", symbol.name);
    if (const check::Predicate* known = find(analysis.program().predicates, symbol))
        text += fmt::format("- {}\n", nature(analysis.program(), *known));
    text += stored(analysis, symbol) + stratum(analysis, symbol);
    return text + rules(analysis, symbol, Role::Derives, "Derived by") + rules(analysis, symbol, Role::Reads, "Read by");
}

// The checked rule or function at the position, which knows the types of its variables.
std::string variable(const Analysis& analysis, const Occurrence& occurrence) {
    const auto type_in = [&](const Table<check::Variable>& variables) -> std::string {
        for (const check::Variable& variable : variables) {
            if (variable.name == occurrence.symbol.name && !(variable.type == check::Type::Error)) return check::type_name(variable.type);
        }
        return "";
    };
    std::string type;
    for (const check::Rule& rule : analysis.program().rules) {
        const bool here =
            rule.span.file == occurrence.span.file && rule.span.begin <= occurrence.span.begin && occurrence.span.end <= rule.span.end;
        if (here && type.empty()) type = type_in(rule.variables);
    }
    const FileTokens& tokens = analysis.tokens().at(occurrence.span.file);
    for (const check::Function& function : analysis.program().functions) {
        if (type.empty() && function.span.file == occurrence.span.file && tokens.item_at(function.span.begin) == occurrence.item)
            type = type_in(function.variables);
    }
    return code(type.empty() ? occurrence.symbol.name : type + " " + occurrence.symbol.name);
}

std::string function(const Analysis& analysis, const Symbol& symbol) {
    const std::string text = declared(analysis, symbol);
    return text.empty() ? fmt::format("`{}` is a function of the language.\n", symbol.name) : text;
}

}  // namespace

std::optional<HoverText> hover(const Analysis& analysis, Position position) {
    const Occurrence* occurrence = analysis.at(position);
    if (occurrence == nullptr) return std::nullopt;
    HoverText result{"", range_of(analysis.files(), occurrence->span)};
    switch (occurrence->symbol.kind) {
        case SymbolKind::Predicate:
            result.markdown = predicate(analysis, occurrence->symbol);
            break;
        case SymbolKind::Constant:
            result.markdown = declared(analysis, occurrence->symbol);
            break;
        case SymbolKind::Function:
            result.markdown = function(analysis, occurrence->symbol);
            break;
        case SymbolKind::Variable:
            result.markdown = variable(analysis, *occurrence);
            break;
        case SymbolKind::Include: {
            const auto file = analysis.included(occurrence->symbol.name);
            result.markdown = file ? "`" + analysis.files().file(*file).path() + "`" : "This file was not found.";
            break;
        }
    }
    return result;
}

}  // namespace meld::lsp
