#include "tests/reference/programs/generate.h"

#include <algorithm>
#include <regex>

#include "tests/reference/evaluator/model.h"
#include "tests/reference/evaluator/ticks.h"
#include "tests/reference/programs/blocks.h"
#include "tests/reference/programs/compiled.h"
#include "tests/reference/trials/run.h"

namespace meld::reference {

namespace {

constexpr int kTries = 12;
constexpr std::size_t kMaxFacts = 6000;

// The world that new rules are tried on, before anything changes.
class Sample {
  public:
    Sample(std::uint64_t seed, const Draft& draft) : case_(retraction::make_case(seed, draft.given)), mirror_(case_, draft.given) {
        for (const retraction::Change& c : case_.bursts[0])
            if (c.tick == 0 && c.kind == retraction::Change::Kind::Give) mirror_.apply(c);
    }

    // Whether every rule of the block has results, and not too many, and the model exists.
    bool good(const Program& program, const Block& block) const {
        Facts given = given_facts(program, mirror_);
        const Scene scene = make_scene(program, case_, mirror_, 1);
        const Model model = make_model(scene, given, Facts(program.predicates.count()));
        if (model.failed || model.too_large || !model.settled) return false;
        std::size_t facts = 0;
        for (const Rows& rows : model.facts) facts += rows.size();
        return facts <= kMaxFacts && productive(program, block, scene, model.facts);
    }

  private:
    static bool productive(const Program& program, const Block& block, const Scene& scene, const Facts& facts) {
        for (const check::Rule& rule : program.rules) {
            if (rule.linear || !mine(block, program.predicates[rule.heads[0].atom.predicate].name)) continue;
            bool any = false;
            for (const auto& [site, links] : scene.links) {
                static_cast<void>(derive(rule, {scene, facts}, site, [&](const Derived&, const Environment&) { return !(any = true); }));
                if (any) break;
            }
            if (!any) return false;
        }
        return true;
    }
    static bool mine(const Block& block, const std::string& name) {
        for (const Declaration& d : block.declarations)
            if (d.name == name) return true;
        return false;
    }

    retraction::Case case_;
    retraction::Mirror mirror_;
};

bool mentions(const std::string& text, std::initializer_list<const char*> words) {
    return std::ranges::any_of(words, [&](const char* word) { return text.find(word) != std::string::npos; });
}

// Whether programs for these worlds may have the block.
bool suitable(const Block& block, Suits suits) {
    if (suits == Suits::Lattices) return true;
    std::string text;
    for (const Declaration& d : block.declarations) text += d.text + "\n";
    for (const DraftRule& r : block.rules) text += print(r) + "\n";
    if (mentions(text, {"vacant(", "cell("})) return false;
    if (suits == Suits::Graphs) return true;
    // Values that follow from numbers, or from an order of nodes: of sums with rounding, too.
    static const std::regex named(R"(@\d|\b([A-Z]|N\d+) [<>]=? ([A-Z]|N\d+)\b|neighbor\([^(),]*,[^(),]*,|\bf\d+ )");
    return !std::regex_search(text, named) &&
           !mentions(text, {"id(", "node2int(", "node2str(", "position(", "at(", "first ", "append ", "avg ", "sum float", "custom ",
                            "randint(", "random ", "min node", "max node", "min :", "max :", "desc ", "asc "});
}

class Generator {
  public:
    Generator(std::uint64_t seed, Suits suits, bool states) : seed_(seed), suits_(suits), states_(states), random_(seed * 7919 + 17) {}

    Generated make() {
        // Few other programs have no views, and none has no functions.
        if (states_ && seed_ % 7 == 3 && suits_ != Suits::Nameless) {
            add(state_block);
            return std::move(out_);
        }
        for (const char* function : kFunctions) out_.draft.declarations.push_back({"function", function});
        for (std::int64_t n = 2 + below(random_, 3); n > 0; --n) accept(given_block(random_, known_, names()));
        if (chance(random_, 40)) constant();
        const bool linear = chance(random_, 45), errs = chance(random_, 8);
        if (linear && suits_ == Suits::Graphs && chance(random_, 50))
            out_.draft.reach = chance(random_, 50) ? Reach::Routes : Reach::OneHop;
        const std::int64_t blocks = 2 + below(random_, 5);
        for (std::int64_t n = 0; n < blocks && out_.refused.empty(); ++n) add(any_block());
        if (errs && out_.refused.empty()) add(error_block);
        if (linear && out_.refused.empty()) {
            if (chance(random_, 40)) add(sweep_block);
            if (out_.refused.empty() && chance(random_, 50)) add(table_block);
            if (out_.refused.empty()) add(out_.draft.reach != Reach::None ? far_block : linear_block);
            if (chance(random_, 50)) add(any_block());
        }
        return std::move(out_);
    }

  private:
    int names() const { return static_cast<int>(out_.draft.declarations.size()); }

    MakeBlock any_block() {
        const std::int64_t way = below(random_, 100);
        return way < 44   ? view_block
               : way < 48 ? rounds_block
               : way < 54 ? contest_block
               : way < 72 ? set_recursion_block
               : way < 86 ? best_recursion_block
               : way < 92 ? improving_block
               : way < 94 ? half_settled_block
               : way < 97 ? walks_block
                          : tree_block;
    }

    void constant() {
        out_.draft.declarations.push_back({"k0", "const k0 = " + std::to_string(below(random_, 5)) + "."});
        out_.draft.declarations.push_back({"kq", "type kq(node, int)."});
        out_.draft.rules.push_back({.heads = {"kq(A, X + k0)"}, .body = {"neighborCount(A, X)", "X > k0"}});
        known_.push_back({.name = "kq", .arguments = {Kind::Int}});
    }

    void add(MakeBlock make_block) {
        for (int tries = 0; tries < kTries; ++tries) {
            ++out_.tried;
            const Block block = make_block(random_, known_, names());
            if (!suitable(block, suits_)) continue;
            Draft more = out_.draft;
            extend(more, block);
            const std::string text = print(more);
            const Result<Program> program = checked(text);
            if (!program) {
                out_.draft = more;
                out_.refused = program.error().message();
                return;
            }
            if (!Sample(seed_, more).good(*program, block)) continue;
            ++out_.kept;
            accept(block);
            note_certain(*program);
            return;
        }
    }

    static void extend(Draft& draft, const Block& block) {
        draft.declarations.insert(draft.declarations.end(), block.declarations.begin(), block.declarations.end());
        draft.rules.insert(draft.rules.end(), block.rules.begin(), block.rules.end());
        draft.given.insert(draft.given.end(), block.given.begin(), block.given.end());
    }
    void accept(const Block& block) {
        extend(out_.draft, block);
        known_.insert(known_.end(), block.known.begin(), block.known.end());
    }
    void note_certain(const Program& program) {
        const Ticks ticks(program);
        for (Known& k : known_)
            for (const PredicateId p : program.predicates.ids())
                if (program.predicates[p].name == k.name) k.certain = ticks.certain(p);
    }

    std::uint64_t seed_;
    Suits suits_;
    bool states_;
    Random random_;
    std::vector<Known> known_;
    Generated out_;
};

}  // namespace

Generated make_program(std::uint64_t seed, Suits suits, bool states) { return Generator(seed, suits, states).make(); }

std::size_t max_degree(const Draft& draft) {
    const std::string text = print(draft);
    if (mentions(text, {"[<- ", "[-> "})) return 30;
    std::size_t most = 0;
    for (const DraftRule& rule : draft.rules) {
        std::size_t links = 0;
        const std::string body = print(rule);
        for (std::size_t at = 0; (at = body.find("neighbor(", at)) != std::string::npos; ++at) ++links;
        most = std::max(most, links);
    }
    return most > 2 ? 20 : 70;
}

}  // namespace meld::reference
