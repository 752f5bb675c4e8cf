// Pass `wait`. An aggregate that waits for its neighbours over a route of the program's own,
//     type total(node, sum int [<- edge]).
// asks which of them are there in a view that says so by catom, and lies beside it:
//     edge@in(A, B) :- edge(B, A), neighbor(A, B).              edge@out(A, B) :- edge(A, B), neighbor(A, B).
// Those over `neighbor` need none: the neighbours are the catoms it touches.
#include <map>

#include "compiler/desugar/desugar.h"
#include "compiler/desugar/made.h"

namespace meld::desugar {

using namespace check;

namespace {

// How a route is followed.
enum class Along { In, Out };

class Waits {
  public:
    explicit Waits(Program& program) : program_(program) {}

    void run() {
        for (const PredicateId id : program_.predicates.ids()) {
            const PredicateId link = program_.predicates[id].complete_link;
            if (!link.valid() || program_.predicates[link].world != WorldSource::None) continue;
            const PredicateId present = view_of(link, program_.predicates[id].complete_outgoing ? Along::Out : Along::In);
            program_.predicates[id].complete_link = present;
        }
    }

  private:
    PredicateId view_of(PredicateId link, Along along) {
        const auto found = made_.find({link, along});
        if (found != made_.end()) return found->second;
        Predicate made;
        made.name = fmt::format("{}@{}", program_.predicates[link].name, along == Along::In ? "in" : "out");
        made.span = program_.predicates[link].span;
        made.arguments = {{Type::Node, ""}, {Type::Node, ""}};
        made.auxiliary = true;
        const PredicateId id = program_.predicates.add(made);

        MadeRule rule(program_, link, made.name);
        Term here = rule.body.atom.arguments[0], there = rule.body.atom.arguments[1];
        if (along == Along::In) std::swap(here, there);
        rule.rule.site = here.variable;
        Clause linked{.kind = Clause::Kind::Atom, .span = made.span};
        linked.atom.predicate = neighbor();
        linked.atom.arguments = {here, there};
        rule.rule.body.push_back(std::move(linked));
        Head head{.kind = Head::Kind::Fact, .span = made.span};
        head.atom.predicate = id;
        head.atom.arguments = {here, there};
        rule.rule.heads.push_back(std::move(head));
        rule.add_to(program_);
        return made_[{link, along}] = id;
    }
    PredicateId neighbor() const {
        for (const PredicateId id : program_.predicates.ids())
            if (program_.predicates[id].world == WorldSource::Neighbor) return id;
        MELD_CHECK(false, "the prelude declares no neighbor/2");
    }

    Program& program_;
    std::map<std::pair<PredicateId, Along>, PredicateId> made_;
};

}  // namespace

void wait_for_neighbours(Program& program) { Waits(program).run(); }

}  // namespace meld::desugar
