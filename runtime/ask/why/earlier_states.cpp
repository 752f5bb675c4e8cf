#include "runtime/ask/why/earlier_states.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "runtime/ask/facts/all_facts.h"
#include "runtime/comm/transport/collective_result.h"

namespace meld::inspect {

Result<void> ask_back(timeline::Timeline& timeline, const std::string& body, const std::function<Result<void>(Explainer&)>& question) {
    sim::Subdomain& now = timeline.simulation().subdomain();
    std::vector<std::unique_ptr<sim::Simulation>> earlier;
    while (true) {
        std::vector<sim::Subdomain*> states = {&now};
        for (const auto& simulation : earlier) states.push_back(&simulation->subdomain());
        std::size_t wanted = 0;
        const Result<void> asked = ask(states, [&](std::span<Facts* const> facts) -> Result<void> {
            Result<Program> program = Program::read(now.module, body);
            if (!program) return tl::unexpected<Error>(program.error());
            if (auto can = program->can_ask(program->question().body); !can) return can;
            Terms terms(*program, now.view());
            const States known{.facts = facts,
                               .tick = now.tick(),
                               .first_tick = timeline.first_tick(),
                               .settled = timeline.ended() == sim::Ending::Quiet,
                               .latency = now.view().latency};
            Explainer explainer(*program, known, terms);
            if (auto done = question(explainer); !done) return done;
            wanted = explainer.wanted();
            return {};
        });
        if (!asked) return asked;
        wanted = comm::value_of_first(now.comm, wanted);
        const auto back = static_cast<std::size_t>(now.tick() - timeline.first_tick());
        wanted = std::min({wanted, kMostStates - 1, back});
        if (wanted <= earlier.size()) return {};
        while (earlier.size() < wanted) {
            auto before = timeline.beside(now.tick() - static_cast<i64>(earlier.size()) - 1);
            if (!before) return tl::unexpected<Error>(before.error());
            if ((*before)->subdomain().totals.stop) return fail("interrupted before there was an answer", "", ExitCode::Interrupted);
            earlier.push_back(std::move(*before));
        }
    }
}

}  // namespace meld::inspect
