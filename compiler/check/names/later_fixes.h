// Fixes of messages about rules that no rule can make alone: a declaration for all uses of a predicate, capitals for all variables of a
// file. The rules add what they know, and finish() writes the fixes.
#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/check/names/scope.h"
#include "compiler/check/program/program.h"
#include "compiler/diagnostics/diagnostics.h"
#include "compiler/syntax/tree.h"

namespace meld::check {

// The text of a rule or a declaration without its full stop.
inline std::string without_stop(std::string text) {
    if (text.ends_with('.')) text.pop_back();
    return text;
}

// How the help of an unknown predicate begins; finish() completes it.
inline constexpr std::string_view kDeclareIt = "declare it: ";

class LaterFixes {
  public:
    LaterFixes(const source::FileSet& files, const Names& names);

    // A new declaration for a file, where its declarations stand; `user` is any rule of that file.
    diagnostics::Edit declaration(Span user, std::string text) const;

    // A use of a predicate that nobody declares, with the types of its arguments as far as the rule tells. A linear one is consumed there.
    enum class Consumed { Perhaps, Certainly };
    void add_use(diagnostics::Diagnostic& message, const syntax::Name& name, const std::vector<Type>& arguments, Consumed consumed);

    // The variables of a rule of original Meld that begin with a small letter, and the message about the first of them all.
    void add_small_variables(diagnostics::Diagnostic& message, Span rule, std::set<std::string> names);

    void finish() const;

  private:
    struct Unknown {
        std::vector<Type> arguments;
        bool linear = false;
        bool fits = true;  // All uses agree.
        std::vector<std::pair<diagnostics::Diagnostic*, Span>> messages = {};
    };
    void declare(const Unknown& unknown) const;
    void write_capitals() const;

    const source::FileSet& files_;
    const Names& names_;
    std::map<std::uint32_t, diagnostics::Edit> places_;  // By file: where a declaration goes.
    std::map<std::pair<std::string, std::size_t>, Unknown> unknown_;
    diagnostics::Diagnostic* small_ = nullptr;
    std::map<std::uint32_t, std::set<std::string>> small_variables_;  // By where their rule begins, in the file of the message.
};

}  // namespace meld::check
