// Declarations: a row of words and brackets becomes modifiers, types, aggregates and names.
//
// `type list int vector.` and `type list p(node).` differ only in their last word, and in `min int D`, `min` is not a type because a type
// follows it; both rules are easier to express here than in the grammar.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>
#include <utility>

#include "compiler/syntax/aggregates.h"
#include "compiler/syntax/parts.h"
#include "compiler/syntax/printer.h"
#include "runtime/base/assert.h"

namespace meld::syntax {

using diagnostics::Kind;
using Form = DeclarationWord::Form;

namespace {

bool is_collection(std::string_view word) { return is_one_of(word, {"list", "set", "array"}); }
bool is_type_word(std::string_view word) {
    return is_collection(word) || is_one_of(word, {"bool", "int", "float", "string", "node", "catom", "module", "addr", "vec3"});
}
std::string lower_case(std::string word) {
    for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return word;
}
bool is_aggregate(std::string_view word) { return declared_aggregate(word) != Aggregate::Custom; }
// A word that can only be an aggregate.
bool is_reserved(std::string_view word) { return is_aggregate(word) && !info(declared_aggregate(word)).has(AggregateInfo::kYields); }
bool has_parameter(std::string_view word) { return info(declared_aggregate(word)).has(AggregateInfo::kParameter); }

bool is_group(const DeclarationWord& word) { return word.form == Form::Group || word.form == Form::Struct; }
bool is_name(const DeclarationWord& word, std::string_view text) { return word.form == Form::Name && word.text == text; }
Name name_of(const DeclarationWord& word) { return {word.text, word.span}; }

Span span_of(const DeclarationWords& words) { return words.front().span.to(words.back().span); }

}  // namespace

// ---- arguments and types

// The first word is an aggregate if a type follows it and it is no type itself.
bool DeclarationReader::starts_with_aggregate(const DeclarationWords& words) const {
    if (words.size() < 2 || words[0].form != Form::Name || is_type_word(words[0].text)) return false;
    const DeclarationWord& second = words[1];
    if (is_group(second)) return second.form == Form::Struct || !has_parameter(words[0].text) || words.size() > 2;
    if (second.form != Form::Name) return false;
    if (is_aggregate(words[0].text) || is_type_word(second.text)) return true;
    // Two unknown words are a type and a name; three are an aggregate, a type and a name.
    return words.size() > 2 && (words[2].form == Form::Name || words[2].form == Form::Variable) && !is_collection(words[2].text);
}

Argument DeclarationReader::argument(const DeclarationWords& words) {
    Argument argument;
    argument.span = span_of(words);
    std::size_t at = 0;
    if (starts_with_aggregate(words)) {
        argument.aggregate = words[0].text;
        argument.aggregate_span = words[0].span;
        at = 1;
        if (has_parameter(words[0].text) && words[1].form == Form::Group && words.size() > 2) parameter(words[at++], argument);
    } else if (words.size() > 1 && words[0].form == Form::Name && is_reserved(words[0].text)) {
        report_.add(Kind::SyntaxError, words[1].span, fmt::format("a type is expected after `{}`", words[0].text)).help =
            fmt::format("{} int D", words[0].text);
        return argument;
    }
    const std::size_t errors_before = report_.error_count();
    argument.type = type(words, at);
    if (report_.error_count() > errors_before) return argument;
    const auto neighbour = [&] {
        if (at >= words.size() || (words[at].form != Form::Neighbour && words[at].form != Form::OutNeighbour)) return;
        argument.neighbour_complete = true;
        argument.neighbour_link = name_of(words[at]);
        argument.neighbour_outgoing = words[at].form == Form::OutNeighbour;
        ++at;
    };
    neighbour();
    const bool named =
        at < words.size() && (words[at].form == Form::Variable || (words[at].form == Form::Name && !is_type_word(words[at].text)));
    if (named) argument.name = name_of(words[at++]);
    neighbour();
    if (at < words.size()) {
        report_.add(Kind::SyntaxError, words[at].span, "`,` or `)` is expected after an argument").help =
            "an argument is a type and a name: int D, list node Path, min float Best";
    }
    return argument;
}

// (3), or (size) with a constant.
void DeclarationReader::parameter(const DeclarationWord& group, Argument& argument) {
    const bool one = group.arguments.size() == 1 && group.arguments[0].size() == 1;
    const DeclarationWord& word = one ? group.arguments[0][0] : group;
    if (word.form == Form::Number)
        argument.aggregate_parameter = word.integer;
    else if (word.form == Form::Name)
        argument.aggregate_parameter = name_of(word);
    else
        report_.add(Kind::SyntaxError, group.span, fmt::format("a number or a constant is expected after `{}`", argument.aggregate)).help =
            fmt::format("{}(3) list int", argument.aggregate);
    argument.aggregate_span = argument.aggregate_span.to(group.span);
}

std::vector<Argument> DeclarationReader::arguments(const std::vector<DeclarationWords>& groups) {
    std::vector<Argument> result;
    result.reserve(groups.size());
    for (const DeclarationWords& words : groups) result.push_back(argument(words));
    return result;
}

Type DeclarationReader::whole_type(const DeclarationWords& words, Span span) {
    if (words.empty()) {
        report_.add(Kind::SyntaxError, span, "a type is missing here");
        return {"int", {}, span};
    }
    std::size_t at = 0;
    Type result = type(words, at);
    if (at < words.size()) report_.add(Kind::SyntaxError, words[at].span, "this is not part of a type");
    return result;
}

// A type and the `list` behind it: `int list` is `list int`.
Type DeclarationReader::type(const DeclarationWords& words, std::size_t& at) {
    Type result = base_type(words, at);
    while (at < words.size() && words[at].form == Form::Name && is_collection(words[at].text)) {
        const Span span = result.span.to(words[at].span);
        Type collection{words[at].text, {}, span};
        collection.arguments.push_back(std::move(result));
        result = std::move(collection);
        ++at;
    }
    return result;
}

Type DeclarationReader::base_type(const DeclarationWords& words, std::size_t& at) {
    MELD_EXPECT(!words.empty() && at <= words.size(), "word {} of {}", at, words.size());
    if (at == words.size()) {
        const Span last = words.back().span;
        report_.add(Kind::SyntaxError, last, fmt::format("a type is expected after `{}`", words.back().text)).help =
            fmt::format("{} int", words.back().text);
        return {"int", {}, last};
    }
    const DeclarationWord& word = words[at++];
    Type result{word.text, {}, word.span};
    if (is_group(word)) {
        result.name = word.form == Form::Struct ? "struct" : "tuple";
        for (const DeclarationWords& field : word.arguments) result.arguments.push_back(whole_type(field, word.span));
        // (int) is int.
        if (result.name == "tuple" && result.arguments.size() == 1) return std::move(result.arguments.front());
        if (result.arguments.empty()) report_.add(Kind::SyntaxError, word.span, "a type is missing between the brackets");
        return result;
    }
    if (word.form != Form::Name) {
        auto& diagnostic =
            report_.add(Kind::SyntaxError, word.span,
                        word.form == Form::Number ? fmt::format("expected a type, found `{}`", word.text) : "a type is expected here");
        if (word.form == Form::Variable)
            diagnostic.help = is_type_word(lower_case(word.text)) ? fmt::format("types are lower-case: `{}`", lower_case(word.text))
                                                                  : fmt::format("the type comes before the name: int {}", word.text);
        if (word.form == Form::Variable && is_type_word(lower_case(word.text)))
            diagnostic.fixes = {safe(diagnostics::write(word.span, lower_case(word.text)))};
        return result;
    }
    if (is_collection(word.text)) {
        result.arguments.push_back(base_type(words, at));
        result.span = result.span.to(result.arguments.front().span);
    }
    return result;
}

// ---- items

namespace {

// The bracket with the arguments and what stands around it.
struct Signature {
    DeclarationWords before;
    const DeclarationWord* group = nullptr;
    DeclarationWords after;
};

Signature signature(const DeclarationWords& words) {
    Signature result;
    for (const DeclarationWord& word : words) {
        if (word.form == Form::Group && result.group == nullptr) {
            result.group = &word;
        } else if (result.group == nullptr) {
            result.before.push_back(word);
        } else {
            result.after.push_back(word);
        }
    }
    return result;
}

}  // namespace

void Builder::type_item(DeclarationWords words, Span span) {
    DeclarationReader reader(report_);
    const bool repeats = words.size() > 2 && is_name(words.back(), "while") && words[words.size() - 2].form == Form::Group;
    if (repeats) words.pop_back();
    const bool declares = words.size() > 1 && words.back().form == Form::Group && words[words.size() - 2].form == Form::Name;
    if (!declares) {
        // type list int vector.
        if (words.size() < 2 || words.back().form != Form::Name) {
            wrong(words.back().span, words.size() < 2 ? "this declares nothing" : "a name is expected here",
                  "type p(node, int). declares a predicate, type list int vector. a type name");
            return;
        }
        Name name = name_of(words.back());
        words.pop_back();
        item(Alias{reader.whole_type(words, span), std::move(name), span});
        return;
    }
    Declaration declaration;
    declaration.repeats = repeats;
    declaration.span = span;
    declaration.arguments = reader.arguments(words.back().arguments);
    declaration.name = name_of(words[words.size() - 2]);
    words.resize(words.size() - 2);
    for (const DeclarationWord& word : words) {
        if (word.form == Form::Name) {
            declaration.modifiers.push_back(name_of(word));
        } else {
            wrong(word.span, "a modifier or the predicate's name is expected here", "type route neighbor(node, node).");
        }
    }
    item(std::move(declaration));
}

void Builder::extern_item(DeclarationWords words, Span span) {
    DeclarationReader reader(report_);
    const bool handle = words.size() == 2 && is_name(words[0], "type") && words[1].form == Form::Name;
    if (handle) {
        item(Extern{name_of(words[1]), std::nullopt, {}, span});
        return;
    }
    const bool function = words.size() >= 2 && words.back().form == Form::Group && words[words.size() - 2].form == Form::Name;
    if (!function) {
        wrong(words.back().span, "an extern function is expected here", "extern float f(int, node).  or a handle: extern type h.");
        return;
    }
    Extern result;
    result.span = span;
    result.name = name_of(words[words.size() - 2]);
    for (const DeclarationWords& argument : words.back().arguments) result.arguments.push_back(reader.argument(argument).type);
    words.resize(words.size() - 2);
    result.result = reader.whole_type(words, result.name.span);
    item(std::move(result));
}

// import linear p(node, int) as q from file.   import p from "file.meld".
void Builder::import_item(DeclarationWords words, Span span) {
    DeclarationReader reader(report_);
    const char* const form = "import p as q from file.  import linear p(node, int) from \"file.meld\".";
    const bool has_source = words.size() >= 3 && is_name(words[words.size() - 2], "from") &&
                            (words.back().form == Form::Name || words.back().form == Form::Text);
    if (!has_source) {
        wrong(span, "an import says from which file", form);
        return;
    }
    Import result;
    result.span = span;
    result.path = words.back().text;
    result.path_span = words.back().span;
    words.resize(words.size() - 2);
    const bool renamed = words.size() >= 3 && is_name(words[words.size() - 2], "as") && words.back().form == Form::Name;
    if (renamed) {
        result.as = name_of(words.back());
        words.resize(words.size() - 2);
    }
    const Signature parts = signature(words);
    const bool all_names =
        std::all_of(parts.before.begin(), parts.before.end(), [](const DeclarationWord& word) { return word.form == Form::Name; });
    if (parts.before.empty() || !all_names || !parts.after.empty() || (parts.group == nullptr && parts.before.size() > 1)) {
        wrong(span_of(words), "an import names one predicate", form);
        return;
    }
    result.predicate = name_of(parts.before.back());
    if (!renamed) result.as = result.predicate;
    if (parts.group != nullptr) {
        Declaration declaration;
        for (std::size_t i = 0; i + 1 < parts.before.size(); ++i) declaration.modifiers.push_back(name_of(parts.before[i]));
        declaration.name = result.predicate;
        declaration.arguments = reader.arguments(parts.group->arguments);
        declaration.span = span_of(words);
        result.declaration = std::move(declaration);
    }
    item(std::move(result));
}

void Builder::function(const Token& name, std::vector<DeclarationWords> parameters, DeclarationWords result, ExprPtr body, Span span) {
    DeclarationReader reader(report_);
    Function function;
    function.name = {name.text, name.span};
    function.span = span;
    for (const DeclarationWords& words : parameters) {
        Argument argument = reader.argument(words);
        if (!argument.name || !argument.aggregate.empty()) {
            wrong(argument.span, "a parameter is a type and a name", "fun twice(int X) : int = 2 * X.");
            continue;
        }
        function.parameters.push_back({std::move(argument.type), std::move(*argument.name)});
    }
    function.result = reader.whole_type(result, name.span);
    function.body = std::move(body);
    item(std::move(function));
}

void Builder::hint(const Token& directive, const std::vector<const Token*>& words, Span span) {
    Hint hint{{directive.text, directive.span}, "", {}, span};
    MELD_EXPECT(!words.empty(), "the hint {} says nothing", directive.text);
    std::uint32_t last_end = words.front()->span.begin;
    for (const Token* word : words) {
        // Blanks and comments between two words become one blank.
        if (word->span.begin != last_end) hint.text += ' ';
        if (word->kind == TokenKind::String) {
            hint.text += quoted_text(word->text);
        } else {
            hint.text += word->text.empty() ? file_.text().substr(word->span.begin, word->span.end - word->span.begin) : word->text;
        }
        last_end = word->span.end;
        if (word->kind == TokenKind::Name) hint.names.push_back(to_name(*word));
    }
    item(std::move(hint));
}

}  // namespace meld::syntax
