// Before pass 1: modules. Gives every name of a module its full name, `module-name`, so that all later passes see one name space. Assumes
// nothing; leaves no rule that uses a name its module does not export.
//
// Names of the prelude, sensed predicates, actions and extern functions belong to the world outside and have no module.
#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "compiler/check/check.h"
#include "compiler/check/names/each_name.h"
#include "compiler/check/program/library.h"
#include "compiler/syntax/parse.h"

namespace meld::check {

using diagnostics::Kind;
using Fit = diagnostics::Edit::Fit;

namespace {

enum class Sort { Predicate, Constant, Function, Type };

struct Import {
    std::uint32_t unit = 0;
    std::string name;
    Span span;
    // It has been reported, and so is nothing that uses it.
    bool wrong = false;
};

struct ModuleNames {
    std::map<std::pair<Sort, std::string>, Span> declared;
    std::map<std::string, Import> imports;
    std::set<std::string> exports;
    Span last_export = {};

    const Span* find(Sort sort, const std::string& name) const {
        const auto found = declared.find({sort, name});
        return found == declared.end() ? nullptr : &found->second;
    }
    // Whatever it is the name of.
    const Span* find(const std::string& name) const {
        for (const Sort sort : {Sort::Predicate, Sort::Constant, Sort::Function, Sort::Type})
            if (const Span* span = find(sort, name)) return span;
        return nullptr;
    }
    bool shows(const std::string& name) const { return exports.empty() || exports.contains(name); }
    std::vector<std::string> shown() const {
        std::set<std::string> result;
        for (const auto& [key, span] : declared)
            if (shows(key.second)) result.insert(key.second);
        return {result.begin(), result.end()};
    }
};

std::string list_of(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "`" : ", `") + name + "`";
    return text;
}

class Separator {
  public:
    Separator(syntax::Tree& tree, std::uint32_t prelude_files, diagnostics::Reporter& report)
        : tree_(tree), prelude_files_(prelude_files), report_(report), names_(tree.units.size()) {}

    void run() {
        for (std::size_t i = 0; i < tree_.items.size(); ++i)
            std::visit([&](auto& item) { collect(item, tree_.unit_of[i]); }, tree_.items[i]);
        same_module_names();
        for (std::size_t i = 0; i < tree_.items.size(); ++i) {
            if (twins_.contains(tree_.unit_of[i])) continue;
            if (const auto* e = std::get_if<syntax::Export>(&tree_.items[i])) check_export(*e, tree_.unit_of[i]);
            if (auto* m = std::get_if<syntax::Import>(&tree_.items[i])) add_import(*m, tree_.unit_of[i]);
        }
        clashes();
        for (std::size_t i = 0; i < tree_.items.size(); ++i) rename_item(i);
        tree_.items.resize(kept_);
        tree_.unit_of.resize(kept_);
    }

    // ---- EachName's visitor: what a name means in unit_

    void predicate(syntax::Name& name, std::optional<std::size_t> arity) {
        if (arity && prelude_.contains({name.text, *arity}) && !names_[unit_].imports.contains(name.text)) return;
        // A condition such as `even(X)` looks like an atom.
        const ModuleNames& own = names_[unit_];
        const bool function = own.find(Sort::Function, name.text) != nullptr || outside_.contains({Sort::Function, name.text}) ||
                              (arity && library_function(name.text, *arity) != nullptr);
        const bool called = function && own.find(Sort::Predicate, name.text) == nullptr && !own.imports.contains(name.text);
        rename(called ? Sort::Function : Sort::Predicate, name.text, name.span);
    }
    void constant(std::string& name, Span span) {
        if (!parameters_.contains(name)) rename(Sort::Constant, name, span);
    }
    // Programs of original Meld write constants in capitals: `const RED = 0.`
    void capital(syntax::Expr& e) {
        const std::string name = std::get<syntax::Variable>(e.node).name;
        if (names_[unit_].find(Sort::Constant, name) != nullptr && !parameters_.contains(name))
            e.node = syntax::Call{full_name(unit_, name), {}, false};
    }
    void function(std::string& name, Span span) { rename(Sort::Function, name, span); }
    void type(syntax::Type& t) {
        if (t.arguments.empty()) rename(Sort::Type, t.name, t.span);
    }

  private:
    const std::string& module(std::uint32_t unit) const { return tree_.units[unit].name; }
    std::string full_name(std::uint32_t unit, const std::string& name) const { return unit == 0 ? name : module(unit) + "-" + name; }

    // ---- what each unit declares

    void declare(Sort sort, const syntax::Name& name, std::uint32_t unit) {
        if (name.span.file < prelude_files_ || name.span.file == tree_.shared_file)
            outside_.emplace(sort, name.text);
        else
            names_[unit].declared.emplace(std::pair(sort, name.text), name.span);
    }
    void collect(const syntax::Declaration& d, std::uint32_t unit) {
        const bool of_the_world = std::any_of(d.modifiers.begin(), d.modifiers.end(),
                                              [](const syntax::Name& m) { return m.text == "sensed" || m.text == "action"; });
        if (d.span.file < prelude_files_) prelude_.emplace(d.name.text, d.arguments.size());
        const bool prelude = prelude_.contains({d.name.text, d.arguments.size()});
        if (of_the_world && !prelude) same_in_the_world(d, unit);
        if (of_the_world || prelude)
            outside_.emplace(Sort::Predicate, d.name.text);
        else
            declare(Sort::Predicate, d.name, unit);
    }
    void collect(const syntax::Constant& c, std::uint32_t unit) { declare(Sort::Constant, c.name, unit); }
    void collect(const syntax::Function& f, std::uint32_t unit) { declare(Sort::Function, f.name, unit); }
    void collect(const syntax::Extern& e, std::uint32_t) { outside_.emplace(e.result ? Sort::Function : Sort::Type, e.name.text); }
    void collect(const syntax::Alias& a, std::uint32_t unit) { declare(Sort::Type, a.name, unit); }
    void collect(const syntax::NodeKind& k, std::uint32_t unit) { declare(Sort::Type, k.name, unit); }
    void collect(const syntax::Export& e, std::uint32_t unit) {
        names_[unit].exports.insert(e.predicate.text);
        names_[unit].last_export = e.span;
    }
    void collect(const syntax::Rule& r, std::uint32_t) {
        if (r.arrow == syntax::Arrow::Linear) linear_files_.insert(r.span.file);
    }
    template <class Other>
    void collect(const Other&, std::uint32_t) {}

    // Two modules may both declare the same sensed predicate in the same words; the first declaration stands for both.
    void same_in_the_world(const syntax::Declaration& d, std::uint32_t unit) {
        std::string text = d.repeats ? "while" : "";
        for (const syntax::Name& m : d.modifiers) text += m.text + " ";
        for (const syntax::Argument& a : d.arguments) text += "," + a.aggregate + " " + syntax::print(a.type);
        const auto [place, first] = of_the_world_.emplace(std::pair(d.name.text, d.arguments.size()), std::pair(unit, text));
        if (!first && place->second.first != unit && place->second.second == text)
            dropped_.insert({unit, d.name.span.file, d.name.span.begin});
    }

    void same_module_names() {
        for (std::size_t i = 1; i < tree_.units.size(); ++i)
            for (std::size_t j = 1; j < i; ++j)
                if (tree_.units[i].name == tree_.units[j].name) {
                    auto& d =
                        report_.add(Kind::ModuleClash, tree_.units[i].span, fmt::format("there are two modules `{}`", tree_.units[i].name));
                    d.labels = {{tree_.units[j].span, "this is the other"}};
                    d.help = "use one of them, or give one another name";
                    twins_.insert(static_cast<std::uint32_t>(i));
                    names_[i].declared.clear();
                }
    }

    void check_export(const syntax::Export& e, std::uint32_t unit) {
        const ModuleNames& own = names_[unit];
        if (own.find(e.predicate.text) != nullptr || tree_.is_lost(e.predicate.text) ||
            outside_.contains({Sort::Predicate, e.predicate.text}))
            return;
        std::vector<std::string> all;
        for (const auto& [key, span] : own.declared) all.push_back(key.second);
        const std::string near = diagnostics::nearest_name(e.predicate.text, all);
        auto& d = report_.add(Kind::NotExported, e.predicate.span,
                              fmt::format("nothing here is named `{}`, so it cannot be exported", e.predicate.text));
        if (near.empty())
            d.help = "declare it in this file";
        else
            d.did_you_mean(near, e.predicate.span);
    }

    void add_import(syntax::Import& i, std::uint32_t unit) {
        const std::string name = i.predicate.text;
        Import import{i.unit, name, i.as.span};
        const bool found =
            i.unit != syntax::Import::kNoUnit && (names_[i.unit].find(name) != nullptr || outside_.contains({Sort::Predicate, name}));
        import.wrong = !found;
        if (i.unit == syntax::Import::kNoUnit) {
            i.declaration.reset();
        } else if (!found || !names_[i.unit].shows(name)) {
            not_shown(i.unit, name, i.predicate.span);
            import.wrong = true;
        } else if (names_[i.unit].find(name) != nullptr) {
            i.predicate.text = full_name(i.unit, name);
        }
        if (import.wrong) i.declaration.reset();
        if (i.unit == unit && i.as.text == name) return;
        const auto [place, first] = names_[unit].imports.emplace(i.as.text, import);
        const Span* declared = names_[unit].find(i.as.text);
        if (first && declared == nullptr) return;
        if (!first && place->second.unit == i.unit && place->second.name == name) return;
        place->second.wrong = true;
        auto& d = report_.add(Kind::ModuleClash, i.as.span, fmt::format("`{}` is imported here and has another meaning too", i.as.text));
        d.labels = {{declared != nullptr ? *declared : place->second.span, "this is the other"}};
        d.help = fmt::format("import it under another name: `import {} as other-{} from ...`", name, name);
        const bool renamed = i.as.span.begin != i.predicate.span.begin;
        d.fixes = {diagnostics::write(i.as.span, (renamed ? "" : name + " as ") + "other-" + name)};
    }

    // What a program may replace in a module that it uses: `const near-reach = 3.` for the `const reach = 2.` of near.
    static bool is_parameter(Sort sort) { return sort != Sort::Predicate; }
    // The program uses all modules, a module its own instances of others.
    bool uses(std::uint32_t user, std::uint32_t unit) const {
        return user == 0 || (tree_.units[unit].user == user && !tree_.units[unit].alias.empty());
    }

    // `gradient-source` declared beside a module gradient that has a `source`.
    void clashes() {
        for (std::uint32_t unit = 1; unit < names_.size(); ++unit)
            for (const auto& [key, span] : names_[unit].declared)
                for (std::uint32_t other = 0; other < names_.size(); ++other) {
                    if (other == unit) continue;
                    const std::string full = full_name(unit, key.second);
                    const std::string prefix = other == 0 ? "" : module(other) + "-";
                    if (!full.starts_with(prefix)) continue;
                    const std::string theirs = full.substr(prefix.size());
                    const Span* declared = names_[other].find(key.first, theirs);
                    if (declared == nullptr) continue;
                    if (is_parameter(key.first) && uses(unit, other) && names_[other].shows(theirs)) continue;  // Seen from there.
                    if (is_parameter(key.first) && uses(other, unit) && names_[unit].shows(key.second)) {
                        dropped_.insert({unit, span.file, span.begin});
                        continue;
                    }
                    auto& d = report_.add(Kind::ModuleClash, *declared,
                                          fmt::format("`{}` is the name of `{}` in the module `{}`", full, key.second, module(unit)));
                    d.labels = {{span, "declared here"}};
                    d.help = fmt::format("leave out this declaration to use that `{}`, or choose another name", key.second);
                    for (const syntax::Item& item : tree_.items)
                        if (const auto* said = std::get_if<syntax::Declaration>(&item);
                            said != nullptr && said->name.span.file == declared->file && said->name.span.begin == declared->begin)
                            d.fixes = {diagnostics::leave_out(said->span, "this declaration", Fit::Item)};
                    names_[other].declared.erase({key.first, theirs});
                    dropped_.insert({other, declared->file, declared->begin});
                    // The iterators of names_[unit] stay good: another unit has lost a name.
                }
    }

    // ---- renaming

    void rename_item(std::size_t i) {
        unit_ = tree_.unit_of[i];
        if (twins_.contains(unit_)) return;
        drop_ = false;
        parameters_.clear();
        syntax::Item& item = tree_.items[i];
        if (auto* f = std::get_if<syntax::Function>(&item))
            for (const syntax::Parameter& p : f->parameters) parameters_.insert(p.name.text);
        EachName<Separator> walk(*this);
        walk.item(item);
        std::visit([&](auto& one) { rename_declared(one); }, item);
        if (drop_) return;
        if (kept_ != i) {
            tree_.items[kept_] = std::move(item);
            tree_.unit_of[kept_] = unit_;
        }
        ++kept_;
    }
    void rename_declared(Sort sort, syntax::Name& name) {
        if (dropped_.contains({unit_, name.span.file, name.span.begin})) drop_ = true;
        if (names_[unit_].find(sort, name.text) != nullptr) name.text = full_name(unit_, name.text);
    }
    void rename_declared(syntax::Declaration& d) {
        if (!prelude_.contains({d.name.text, d.arguments.size()})) rename_declared(Sort::Predicate, d.name);
    }
    void rename_declared(syntax::Constant& c) { rename_declared(Sort::Constant, c.name); }
    void rename_declared(syntax::Function& f) { rename_declared(Sort::Function, f.name); }
    void rename_declared(syntax::Alias& a) { rename_declared(Sort::Type, a.name); }
    void rename_declared(syntax::NodeKind& k) { rename_declared(Sort::Type, k.name); }
    template <class Other>
    void rename_declared(Other&) {}

    void rename(Sort sort, std::string& name, Span span) {
        const ModuleNames& own = names_[unit_];
        if (const auto import = own.imports.find(name); import != own.imports.end()) {
            const Import& i = import->second;
            if (i.wrong)
                drop_ = true;
            else if (names_[i.unit].find(sort, i.name) != nullptr)
                name = full_name(i.unit, i.name);
            else if (outside_.contains({sort, i.name}))
                name = i.name;
            return;
        }
        if (own.find(sort, name) != nullptr) {
            name = full_name(unit_, name);
            return;
        }
        if (unit_ != 0) name_of_instance(name);
        if (outside_.contains({sort, name}) || qualified(sort, name, span) || unit_ == 0) return;
        if (const Span* declared = names_[0].find(sort, name)) {
            // In a file of original Meld a bare name is a variable, whatever else it may mean elsewhere.
            if (sort == Sort::Constant && !linear_files_.contains(span.file))
                name = full_name(unit_, name);
            else
                hidden(name, span, *declared);
        } else if (sort == Sort::Predicate && !tree_.is_lost(name)) {
            // Unknown everywhere: looked for among the module's own.
            name = full_name(unit_, name);
        }
    }

    void hidden(const std::string& name, Span span, Span declared) {
        auto& d = report_.add(Kind::NotExported, span,
                              fmt::format("`{}` belongs to the program, and the module `{}` does not see it", name, module(unit_)));
        d.labels = {{declared, "declared here"}};
        d.help = "declare and export a predicate in the module, and let the program derive it";
        drop_ = true;
    }

    // `near-dist` in the module channel that says use "gradient" as near: `channel-near-dist` in full.
    void name_of_instance(std::string& name) const {
        for (const syntax::Unit& unit : tree_.units)
            if (unit.user == unit_ && !unit.alias.empty() && name.starts_with(unit.alias + "-")) {
                name = full_name(unit_, name);
                return;
            }
    }

    // `gradient-dist`: a name of the module gradient. False where no module comes into question.
    bool qualified(Sort sort, const std::string& name, Span span) {
        std::optional<std::uint32_t> asked;
        for (std::uint32_t unit = 1; unit < names_.size(); ++unit) {
            if (!name.starts_with(module(unit) + "-")) continue;
            const std::string rest = name.substr(module(unit).size() + 1);
            if (names_[unit].find(sort, rest) != nullptr && (unit == unit_ || names_[unit].shows(rest))) return true;
            if (!asked || module(unit).size() > module(*asked).size()) asked = unit;
        }
        if (!asked || *asked == unit_ || sort == Sort::Type || names_[0].find(sort, name) != nullptr) return false;
        // A bare name may as well be a variable of original Meld.
        if (sort == Sort::Constant && names_[*asked].find(sort, name.substr(module(*asked).size() + 1)) == nullptr) return false;
        not_shown(*asked, name.substr(module(*asked).size() + 1), span);
        drop_ = true;
        return true;
    }

    void not_shown(std::uint32_t unit, const std::string& name, Span span) {
        const ModuleNames& names = names_[unit];
        // It may be declared in an item that could not be read.
        if (tree_.is_lost(name) && names.find(name) == nullptr) return;
        const std::string whose = unit == 0 ? "the program" : fmt::format("the module `{}`", module(unit));
        const Span* declared = names.find(name);
        auto& d = report_.add(
            Kind::NotExported, span,
            declared != nullptr ? fmt::format("`{}` is private to {}", name, whose) : fmt::format("{} has no `{}`", whose, name));
        if (declared != nullptr) d.labels = {{*declared, "declared here"}};
        const std::vector<std::string> shown = names.shown();
        const std::string near = diagnostics::nearest_name(name, shown);
        if (declared != nullptr) {
            d.help = fmt::format("add `export {}.` to its file; it shows {}", name, shown.empty() ? "no names" : list_of(shown));
            const std::string words = fmt::format("export {}.", name);
            d.fixes = {{.title = fmt::format("Add `{}` to its file", words), .edits = {{names.last_export, words, Fit::After}}}};
            return;
        }
        // A name alone stands in an import, elsewhere one with that of its module.
        const bool alone = span.end - span.begin == name.size();
        if (!near.empty()) d.fixes = {diagnostics::write(span, alone ? near : full_name(unit, near), Fit::Name)};
        d.help = (near.empty() ? "" : fmt::format("did you mean `{}`? ", near)) +
                 (shown.empty() ? "it shows no names" : "it shows " + list_of(shown));
    }

    syntax::Tree& tree_;
    std::uint32_t prelude_files_;
    diagnostics::Reporter& report_;
    std::vector<ModuleNames> names_;                  // By unit.
    std::set<std::pair<Sort, std::string>> outside_;  // Names that no module owns.
    std::map<std::pair<std::string, std::size_t>, std::pair<std::uint32_t, std::string>> of_the_world_;
    std::set<std::uint32_t> linear_files_;
    std::set<std::uint32_t> twins_;                          // Units whose name another has.
    std::set<std::pair<std::string, std::size_t>> prelude_;  // Predicates of the prelude, with their number of arguments.
    // Units and places of declarations that clash with a module's name.
    std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> dropped_;
    std::uint32_t unit_ = 0;
    std::set<std::string> parameters_;
    bool drop_ = false;
    std::size_t kept_ = 0;
};

}  // namespace

void separate_modules(syntax::Tree& tree, std::uint32_t prelude_files, diagnostics::Reporter& report) {
    Separator(tree, prelude_files, report).run();
}

}  // namespace meld::check
