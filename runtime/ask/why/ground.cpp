#include "runtime/ask/why/ground.h"

#include <fmt/format.h>

#include <span>

#include "runtime/ask/facts/all_facts.h"
#include "runtime/ask/why/explainer.h"
#include "runtime/base/bytes.h"

namespace meld::inspect {

Result<Ground> read_ground(sim::Subdomain& subdomain, const std::string& fact) {
    ByteWriter mine;
    sim::Subdomain* const states[] = {&subdomain};
    const Result<void> asked = ask(states, [&](std::span<Facts* const> facts) -> Result<void> {
        const Result<Program> program = Program::read(subdomain.module, fact);
        if (!program) return tl::unexpected<Error>(program.error());
        Terms terms(*program, subdomain.view());
        Explainer explainer(*program, {.facts = facts, .tick = subdomain.tick()}, terms);
        const Result<Known> known = explainer.asked();
        if (!known) return tl::unexpected<Error>(known.error());
        if (!known->whole())
            return fail(fmt::format("{} leaves something open", explainer.text(*known)), "Give every argument its value: token(@3, 7)");
        const check::Predicate& p = explainer.predicate(known->predicate);
        mine.write_string(explainer.text(*known));
        mine.write_string(p.name);
        mine.write(*known->catom);
        for (std::size_t i = 0; i < known->arguments.size(); ++i)
            mine.write_string(explainer.value_text(p.arguments[i + 1].type, *known->arguments[i]));
        return {};
    });
    if (!asked) return tl::unexpected<Error>(asked.error());
    const auto all = subdomain.comm.allgather_any(mine.view());
    ByteReader in(all[0], "a fact that is written");
    Ground out{.text = in.read_string(), .predicate = in.read_string(), .catom = in.read<std::uint64_t>()};
    while (!in.done()) out.arguments.push_back(in.read_string());
    return out;
}

}  // namespace meld::inspect
