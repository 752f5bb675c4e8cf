// Before pass 1: constants, functions and type names of the program's file that no rule or declaration uses, directly or not. It reads the
// syntax tree, because later passes replace names by their meaning. Assumes separate_modules(): every name means one thing. Whether to warn
// is known only after the check.
#include <map>

#include "compiler/check/names/each_name.h"
#include "compiler/lint/lint.h"

namespace meld::lint {

using namespace check;
using diagnostics::Diagnostic;
using diagnostics::Kind;
using Fit = diagnostics::Edit::Fit;

namespace {

enum class Sort { Constant, Function, Type };
using Key = std::pair<Sort, std::string>;

class Uses {
  public:
    Uses(const source::FileSet& files, syntax::Tree& tree, std::uint32_t file) : files_(files), tree_(tree), file_(file) {}

    std::vector<Diagnostic> unused() {
        look_through();
        // A file without rules is there to be included; a module without exports makes everything public.
        if (!rules_ || (module_ && !exports_)) return {};
        for (std::size_t i = 0; i < tree_.items.size(); ++i) item(i);
        // Follows each needed name to the names that it needs; the list grows on the way.
        for (std::size_t i = 0; i < needed_.size(); ++i)
            for (const Use& use : declared_.at(needed_[i]).uses) need(use.key);
        std::vector<Diagnostic> found;
        for (const auto& [key, declared] : declared_)
            if (!declared.needed && declared.name.file == file_ && !said_otherwise(files_.text(declared.name)))
                found.push_back(message(key, declared));
        return found;
    }

    // ---- EachName's visitor

    // A condition such as even(X) looks like an atom.
    void predicate(const syntax::Name& name, std::optional<std::size_t>) { use({Sort::Function, name.text}, name.span); }
    void constant(const std::string& name, Span span) {
        if (!parameters_.contains(name)) use({Sort::Constant, name}, span);
    }
    // Constants in capitals are known as such by now.
    void capital(const syntax::Expr&) {}
    void function(const std::string& name, Span span) { use({Sort::Function, name}, span); }
    void type(const syntax::Type& t) { use({Sort::Type, t.name}, t.span); }

  private:
    struct Use {
        Key key;
        Span span;
    };
    struct Declared {
        Span name;
        Span item;
        std::vector<Use> uses = {};  // In its own declaration.
        bool outside = false;        // An extern: no module owns it.
        bool needed = false;
    };

    void look_through() {
        for (const syntax::Item& any : tree_.items) {
            if (const auto* c = std::get_if<syntax::Constant>(&any)) declare(Sort::Constant, c->name, c->span);
            if (const auto* f = std::get_if<syntax::Function>(&any)) declare(Sort::Function, f->name, f->span);
            if (const auto* e = std::get_if<syntax::Extern>(&any)) declare(e->result ? Sort::Function : Sort::Type, e->name, e->span, true);
            if (const auto* a = std::get_if<syntax::Alias>(&any)) declare(Sort::Type, a->name, a->span);
            if (const auto* k = std::get_if<syntax::NodeKind>(&any)) declare(Sort::Type, k->name, k->span);
            if (const auto* r = std::get_if<syntax::Rule>(&any)) rules_ = rules_ || r->span.file == file_;
            if (const auto* m = std::get_if<syntax::Module>(&any)) module_ = module_ || m->span.file == file_;
            if (const auto* e = std::get_if<syntax::Export>(&any)) exports_ = exports_ || e->span.file == file_;
        }
    }
    void declare(Sort sort, const syntax::Name& name, Span item, bool outside = false) {
        declared_.emplace(Key{sort, name.text}, Declared{.name = name.span, .item = item, .outside = outside});
    }

    void item(std::size_t i) {
        syntax::Item& any = tree_.items[i];
        user_ = nullptr;
        parameters_.clear();
        if (const auto* c = std::get_if<syntax::Constant>(&any)) user_ = &declared_.at({Sort::Constant, c->name.text});
        if (const auto* a = std::get_if<syntax::Alias>(&any)) user_ = &declared_.at({Sort::Type, a->name.text});
        if (const auto* e = std::get_if<syntax::Extern>(&any); e != nullptr && e->result)
            user_ = &declared_.at({Sort::Function, e->name.text});
        // Whoever uses a module sees its externs.
        if (const auto* e = std::get_if<syntax::Extern>(&any); e != nullptr && module_)
            need({e->result ? Sort::Function : Sort::Type, e->name.text});
        if (const auto* f = std::get_if<syntax::Function>(&any)) {
            user_ = &declared_.at({Sort::Function, f->name.text});
            for (const syntax::Parameter& p : f->parameters) parameters_.insert(p.name.text);
        }
        // `type vector p(node).` has no meaning, and has a separate message.
        if (const auto* d = std::get_if<syntax::Declaration>(&any))
            for (const syntax::Name& m : d->modifiers) need({Sort::Type, m.text});
        if (const auto* e = std::get_if<syntax::Export>(&any)) {
            const std::string& module = tree_.units[tree_.unit_of[i]].name;
            for (const Sort sort : {Sort::Constant, Sort::Function, Sort::Type})
                need({sort, module.empty() ? e->predicate.text : module + "-" + e->predicate.text});
        }
        EachName<Uses> walk(*this);
        walk.item(any);
    }
    // A constant of the name of a literal looks like that where it is used.
    static bool said_otherwise(std::string_view name) { return name.starts_with("_") || name == "true" || name == "false"; }
    void use(Key key, Span span) {
        if (user_ == nullptr)
            need(key);
        else if (declared_.contains(key))
            user_->uses.push_back({std::move(key), span});
    }
    void need(const Key& key) {
        const auto found = declared_.find(key);
        if (found == declared_.end() || found->second.needed) return;
        found->second.needed = true;
        needed_.push_back(key);
    }

    Diagnostic message(const Key& key, const Declared& declared) const {
        const std::string_view name = files_.text(declared.name);
        Diagnostic d{
            .kind = Kind::UnusedName, .span = declared.name, .message = fmt::format("the {} `{}` is never used", word(key.first), name)};
        bool itself = false, others = false;
        for (const auto& [other, by] : declared_)
            for (const Use& u : by.uses) {
                others = others || (u.key == key && other != key);
                if (u.key != key || by.name.file != file_) continue;
                itself = itself || other == key;
                if (other != key && d.labels.empty())
                    d.labels.push_back({u.span, fmt::format("only `{}` uses it, which is never used itself", files_.text(by.name))});
            }
        if (itself && d.labels.empty()) d.message = fmt::format("the {} `{}` is used by itself alone", word(key.first), name);
        d.help = "leave it out";
        if (key.first == Sort::Constant)
            d.help += fmt::format(", or name it `_{}`", name);
        else if (!declared.outside)
            d.help += fmt::format(", or write `export {}.` if other files are to use it", name);
        // What others name goes after them.
        if (!others) d.fixes = {diagnostics::leave_out(declared.item, "the declaration", Fit::Item)};
        if (!others && key.first == Sort::Constant) d.fixes.push_back(diagnostics::write(declared.name, fmt::format("_{}", name)));
        if (key.first != Sort::Constant && !declared.outside)
            d.fixes.push_back({.title = fmt::format("Write `export {}.`", name),
                               .edits = {{declared.item, fmt::format("export {}.", name), Fit::After}}});
        return d;
    }
    static const char* word(Sort sort) { return sort == Sort::Constant ? "constant" : sort == Sort::Function ? "function" : "type"; }

    const source::FileSet& files_;
    syntax::Tree& tree_;
    std::uint32_t file_;
    std::map<Key, Declared> declared_;  // In all files, for what is used by what is used.
    std::vector<Key> needed_;
    Declared* user_ = nullptr;  // Whose declaration is looked at; none: something that is there for its own sake.
    std::set<std::string> parameters_;
    bool rules_ = false, module_ = false, exports_ = false;
};

}  // namespace

std::vector<Diagnostic> find_unused_names(const source::FileSet& files, syntax::Tree& tree, std::uint32_t program_file) {
    return Uses(files, tree, program_file).unused();
}

}  // namespace meld::lint
