#include "runtime/engine/eval/failure.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "runtime/base/units.h"
#include "runtime/engine/tuple/value_text.h"

namespace meld::eval {

namespace {

// The file of a rule, if it is not the program's file.
std::string place(const ModuleInfo& module, const RuleInfo& rule) {
    const std::string_view file = rule.file;
    return file.empty() || file == std::string(module.program_name) + ".meld" ? "" : fmt::format(" of {}", file);
}

// The name of a predicate in the program. Auxiliaries that the compiler made for `p` are called p@..., p' or p'facts.
std::string_view own_name(const ModuleInfo& module, u32 predicate) {
    std::string_view name = module.predicates[predicate].name;
    if (!module.predicates[predicate].auxiliary) return name;
    name = name.substr(0, name.find('@'));
    if (name.ends_with("'facts")) name.remove_suffix(6);
    if (name.ends_with("'")) name.remove_suffix(1);
    return name;
}

// The names of the predicates of a column in the program.
std::string kept_in(const ModuleInfo& module, u32 column) {
    std::string names;
    if (column >= module.column_count) return names;
    for (u32 i = 0; i < module.predicate_count; ++i) {
        if (module.predicates[i].column != column) continue;
        const std::string quoted = fmt::format("`{}`", own_name(module, i));
        if (names.find(quoted) == std::string::npos) names += (names.empty() ? "" : " or ") + quoted;
    }
    return names;
}

// The string at fault as a literal; a long one is cut and ends with dots.
std::string text_of(const Failure& f) {
    const auto all = static_cast<std::size_t>(f.left.integer);
    std::string_view start(f.text, std::min<std::size_t>(all, kMaxTrapText_bytes));
    // A character that continues beyond the end is left out.
    if (start.size() < all) {
        while (!start.empty() && (static_cast<unsigned char>(start.back()) & 0xc0) == 0x80) start.remove_suffix(1);
        if (!start.empty() && (static_cast<unsigned char>(start.back()) & 0x80) != 0) start.remove_suffix(1);
    }
    return tuple::print_text(start) + (start.size() < all ? "..." : "");
}

}  // namespace

std::string describe(const ModuleInfo& module, const Failure& f) {
    std::string where = fmt::format("at catom @{} in tick {}", f.catom, f.tick);
    if (f.rule != kNone32) {
        const RuleInfo& rule = module.rules[f.rule];
        std::string_view name = rule.name, text = rule.text;
        if (text.ends_with('.')) text.remove_suffix(1);
        // Auxiliaries for the facts of p are called p@...
        where = *rule.file == '\0' ? fmt::format("among the facts of `{}` {}", name.substr(0, name.find('@')), where)
                                   : fmt::format("in rule {}{} {}: {}", name, place(module, rule), where, text);
    } else if (const std::string names = kept_in(module, f.column); !names.empty()) {
        where = fmt::format("among the facts of {} {}", names, where);
    }
    const auto operand = [&](Value v) { return f.real ? fmt::format("{:.17g}", v.real) : fmt::format("{}", v.integer); };
    switch (f.trap) {
        case Trap::None:
            return "";
        case Trap::Overflow:
            if (f.real) return fmt::format("a number became too large for a float ({}) {}", operand(f.left), where);
            return fmt::format("a number became too large ({} and {}) {}", operand(f.left), operand(f.right), where);
        case Trap::DivisionByZero:
            return fmt::format("{} is divided by zero {}", operand(f.left), where);
        case Trap::NotANumber:
            return fmt::format("a value that is not a number was computed {}", where);
        case Trap::BadConversion:
            return fmt::format("{} has no such value as an int {}", operand(f.left), where);
        case Trap::TooManyDerivations:
            return fmt::format("a catom made more than {} derivations in one tick {}", operand(f.left), where);
        case Trap::TooManyFacts:
            return fmt::format("a catom holds more than {} facts of one predicate {}", operand(f.right), where);
        case Trap::BadIndex:
            return fmt::format("there is no element {} in a list of {} {}", operand(f.left), operand(f.right), where);
        case Trap::TooLong:
            return fmt::format("a list has {} items, and the maximum is {} {}", operand(f.left), operand(f.right), where);
        case Trap::TooMuchMemory:
            return fmt::format("the rules of a catom take more than {} of memory in one tick {}", format_bytes(2 * kMaxChunk), where);
        case Trap::TextTooLong:
            return fmt::format("a string has {} bytes, and the maximum is {} {}", operand(f.left), operand(f.right), where);
        case Trap::NotAnInt:
            return fmt::format("{} is no int {}", text_of(f), where);
        case Trap::NotAFloat:
            return fmt::format("{} is no float {}", text_of(f), where);
        case Trap::NegativePower:
            return fmt::format("{} ^ {} is no int {}", operand(f.left), operand(f.right), where);
        case Trap::NothingBelow:
            return fmt::format("no random int is from 0 to below {} {}", operand(f.left), where);
        case Trap::RankTooHigh:
            return fmt::format("a fact rests on a chain of more than {} derivations {}", operand(f.right), where);
        case Trap::TooDeep:
            return fmt::format("functions call each other more than {} deep {}", operand(f.left), where);
    }
    return "";
}

std::string cure(const Failure& f) {
    switch (f.trap) {
        case Trap::TooManyDerivations:
            return "The program may never become quiescent; raise [limits] max_derivations_per_tick in the world, or --limit "
                   "derivations=N, if it should";
        case Trap::TooManyFacts:
            return "Raise [limits] max_facts_per_catom in the world, or --limit facts=N, if it should";
        case Trap::TooMuchMemory:
            return "Facts and lists that grow step by step are copied in every step: make fewer of them, or fewer steps a tick";
        case Trap::TooLong:
        case Trap::TextTooLong:
            return "Raise [limits] max_list in the world, or --limit list=N, if it should";
        case Trap::NotAnInt:
            return "An int is written only in digits, with `-` before them if it is negative, and fits in 64 bits";
        case Trap::NotAFloat:
            return "A float is written as in a program, without blanks: \"1.5\", \"-2\" or \"3e-4\"";
        case Trap::NegativePower:
            return fmt::format("The power of a float may have a negative exponent: `{}.0 ^ {}`", f.left.integer, f.right.integer);
        case Trap::Overflow:
            return f.real ? "A float lies between -1.797e308 and 1.797e308, and log(0.0) below all of them" : "";
        case Trap::RankTooHigh:
            return "Facts that were lost and derived again from each other for a long time have such chains: give the facts they begin "
                   "with again";
        case Trap::NothingBelow:
            return "`randint(N)` needs an N of at least 1";
        default:
            return "";
    }
}

}  // namespace meld::eval
