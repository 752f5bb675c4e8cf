#include "compiler/check/program/library.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <string_view>

#include "compiler/check/program/types.h"
#include "runtime/base/assert.h"

namespace meld::check {

namespace {

// Reads "list T, int -> T".
class SignatureReader {
  public:
    explicit SignatureReader(const std::string& text) : text_(text) {}

    void read(LibraryFunction& f) {
        skip();
        if (!taken("->")) {
            do f.parameters.push_back(type());
            while (taken(","));
            MELD_CHECK(taken("->"), "the signature of {} has no result", f.name);
        }
        f.result = type();
        MELD_CHECK(at_ == text_.size(), "the signature of {} ends in rubbish", f.name);
    }

  private:
    void skip() {
        while (at_ < text_.size() && text_[at_] == ' ') ++at_;
    }
    bool taken(const std::string& word) {
        skip();
        if (text_.compare(at_, word.size(), word) != 0) return false;
        at_ += word.size();
        skip();
        return true;
    }
    LibraryType type() {
        skip();
        std::string word;
        while (at_ < text_.size() && std::isalnum(static_cast<unsigned char>(text_[at_]))) word += text_[at_++];
        skip();
        if (word.size() == 1) return {Type::Kind::Error, word[0], {}};
        if (word == "list") return {Type::Kind::List, 0, {type()}};
        if (word == "set") return {Type::Kind::Set, 0, {type()}};
        if (word == "array") return {Type::Kind::Array, 0, {type()}};
        const auto simple = language_types().find(word);
        MELD_CHECK(simple != language_types().end(), "the library has no type {}", word);
        return {simple->second.kind, 0, {}};
    }

    const std::string& text_;
    std::size_t at_ = 0;
};

std::vector<LibraryFunction> make_library() {
    std::vector<LibraryFunction> all = {
#define MELD_SECTION(what) {.name = what, .signature = "", .text = ""},
#define MELD_FUNCTION(the_name, types, function, says) {.name = the_name, .signature = types, .text = says, .cpp = function},
#define MELD_COMPARING_FUNCTION(the_name, types, function, says) \
    {.name = the_name, .signature = types, .text = says, .cpp = function, .compares = true},
#define MELD_RANDOM_FUNCTION(the_name, types, function, says) \
    {.name = the_name, .signature = types, .text = says, .cpp = function, .random = true},
#define MELD_OPERATOR(the_name, types, its_op, says) {.name = the_name, .signature = types, .text = says, .op = Op::its_op},
#include "compiler/check/program/library.def"
#undef MELD_SECTION
#undef MELD_FUNCTION
#undef MELD_COMPARING_FUNCTION
#undef MELD_RANDOM_FUNCTION
#undef MELD_OPERATOR
    };
    // Sections stand between the functions, without a signature.
    std::string section;
    for (LibraryFunction& f : all) {
        MELD_CHECK(f.signature.empty() || !f.name.empty(), "a function of type {} has no name", f.signature);
        if (f.signature.empty())
            section = f.name;
        else
            SignatureReader(f.signature).read(f);
        f.section = section;
    }
    std::erase_if(all, [](const LibraryFunction& f) { return f.signature.empty(); });
    return all;
}

// Older programs say in the name what the elements of a list are: `intlistsort` is `listsort`.
std::string without_element(const std::string& name) {
    for (const std::string_view element : {"int", "float", "node", "string"})
        if (name.starts_with(element) && name.compare(element.size(), 4, "list") == 0 && name.size() > element.size() + 4)
            return name.substr(element.size());
    return name;
}

}  // namespace

const std::vector<LibraryFunction>& library() {
    static const std::vector<LibraryFunction> all = make_library();
    return all;
}

const LibraryFunction* library_function(const std::string& name, std::size_t arguments) {
    static const std::multimap<std::string, const LibraryFunction*> by_name = [] {
        std::multimap<std::string, const LibraryFunction*> map;
        for (const LibraryFunction& f : library()) map.emplace(f.name, &f);
        return map;
    }();
    MELD_EXPECT(!name.empty(), "a function without a name");
    const auto [first, last] = by_name.equal_range(without_element(name));
    for (auto f = first; f != last; ++f)
        if (f->second->parameters.size() == arguments) return f->second;
    return first == last ? nullptr : first->second;
}

std::span<const std::string_view> older_functions() {
    static constexpr std::string_view kNames[] = {"wastetime",      "queens_violation", "minimax_score",    "minimax_points",
                                                  "minimax_score2", "minimax_points2",  "degeneratevector", "demergemessages"};
    return kNames;
}

bool is_older(std::string_view name) { return std::ranges::find(older_functions(), name) != older_functions().end(); }

const MachineState* machine_state(std::string_view word) {
    static constexpr std::string_view kWork =
        "leave it out: results do not depend on how much a catom has done. Rules can count: `counter(A, N), p(A) -o counter(A, N + 1).`";
    static constexpr std::string_view kOrder = "leave it out: results do not depend on which catom is evaluated first";
    static constexpr std::string_view kNever = "it never holds, since no catom changes processors: leave out a rule that waits for it";
    static constexpr std::string_view kThreads =
        "here each node is a thread of its own: for a list of all, write facts that name the nodes, or let them tell each other";
    static constexpr MachineState kStates[] = {{"facts-consumed", kWork},   {"facts-proved", kWork},     {"facts-derived", kWork},
                                               {"queue-size", kWork},       {"priority", kOrder},        {"default-priority", kOrder},
                                               {"cpu-id", kOrder},          {"cpu-static", kOrder},      {"just-moved", kNever, true},
                                               {"is-moving", kNever, true}, {"is-static", kNever, true}, {"nodepriority", kOrder},
                                               {"thread-list", kThreads},   {"other-thread", kThreads},  {"leader-thread", kThreads}};
    std::string plain(word);
    std::ranges::replace(plain, '_', '-');
    const auto found = std::ranges::find(kStates, std::string_view(plain), &MachineState::word);
    return found == std::end(kStates) ? nullptr : &*found;
}

bool match(const LibraryType& parameter, const Type& argument, LibraryBindings& bindings) {
    if (argument == Type::Error) return true;
    if (parameter.variable != 0) {
        Type& bound = bindings[parameter.variable];
        const auto both = join(bound, argument);
        if (both) bound = *both;
        return both.has_value();
    }
    if (parameter.kind == Type::Kind::Float && argument == Type::Int) return true;
    if (parameter.kind != argument.kind || parameter.parts.size() != argument.parts.size()) return false;
    bool fits = true;
    for (std::size_t i = 0; i < parameter.parts.size(); ++i) fits = match(parameter.parts[i], argument.parts[i], bindings) && fits;
    return fits;
}

namespace {

bool draws(const Program& program, const Term& term, std::set<FunctionId>& seen) {
    bool found = false;
    each_subterm(term, [&](const Term& t) {
        if (found) return;
        if (t.op == Op::Library) {
            const LibraryFunction* f = library_function(t.text, t.operands.size());
            found = f != nullptr && f->random;
        } else if (t.op == Op::Call && seen.insert(t.function).second) {
            found = draws(program, program.functions[t.function].body, seen);
        }
    });
    return found;
}

}  // namespace

bool is_random(const Program& program, const Term& term) {
    std::set<FunctionId> seen;
    return draws(program, term, seen);
}

Type substitute(const LibraryType& type, const LibraryBindings& bindings) {
    if (type.variable != 0) {
        const auto found = bindings.find(type.variable);
        return found == bindings.end() ? Type::Error : found->second;
    }
    Type out{type.kind};
    for (const LibraryType& part : type.parts) out.parts.push_back(substitute(part, bindings));
    return out;
}

}  // namespace meld::check
