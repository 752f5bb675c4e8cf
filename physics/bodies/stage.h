// The parts of a step: its times, its stages, and the parameters of its passes.
#pragma once

#include <bit>
#include <cstdint>

namespace meld::physics {

struct Settings;
struct Wrench;

inline constexpr int kColours = 8;

struct StepTimes {
    double dt_s;
    int substeps;
    double substep_s() const { return dt_s / substeps; }
    // When a substep of the step after this many others begins, s. The end of a step is the beginning of the next one, to the last bit.
    double start_s(std::uint64_t tick, int substep) const {
        return static_cast<double>(tick * static_cast<std::uint64_t>(substeps) + static_cast<std::uint64_t>(substep)) * substep_s();
    }
};

struct Stage {
    enum class Kind {
        // Makes the candidate list if needed, and copies the state.
        Prepare,
        // Decides which blocks may sleep.
        FindResting,
        // Blocks fall asleep or wake; gaps and normals are recomputed if they are not up to date.
        UpdateSleep,
        // Magnets and plates of the blocks of one colour.
        Actuate,
        // Gravity, wrenches and damping.
        Accelerate,
        // By colour: the warm-start impulses; a sweep; a relaxation sweep.
        WarmStart,
        Solve,
        Relax,
        // The same of joints, after all contacts.
        WarmStartJoints,
        SolveJoints,
        RelaxJoints,
        // Which colours have contacts that would bounce now; then, by colour, a sweep of restitution.
        FindBounces,
        Bounce,
        // In a divided world with composites, behind the colours: those that collide, block after block.
        BounceComposites,
        Move,
        Refresh,
        // In a divided world: what contacts have done to members of composites whose loads somebody wants.
        ShareLoads,
        // Touch events and the end of the tick.
        Finish,
    };
    Kind kind;
    int colour = -1;
    // For FindBounces: how many of the following stages do nothing if nothing bounces.
    int bounce_stages = 0;
    // For Refresh: whether the step goes on after it, so that contacts of shapes may follow their bodies until its end.
    bool goes_on = false;
    // For Prepare: whether subdomains tell each other which blocks joints and composites link, and where copies of composites are.
    bool shares_links = false;
    // For BounceComposites, which is run several times (subdomain.h): which time it is.
    int round = 0;

    // Whether other subdomains must receive its results before the next stage (subdomain.h).
    bool must_exchange() const {
        return colour >= 0 || kind == Kind::FindResting || kind == Kind::BounceComposites || kind == Kind::ShareLoads || shares_links;
    }
    bool has_rounds() const { return kind == Kind::BounceComposites; }
    // Whether it is the end of a sweep over all colours, after which the copies of composites take their mean.
    bool ends_sweep() const { return colour == kColours - 1 && (kind == Kind::WarmStart || kind == Kind::Solve || kind == Kind::Relax); }
    // Whether the subdomains must combine the results of this stage, and may then skip stages.
    bool must_agree() const { return kind == Kind::FindBounces; }
    // How many of the following stages do nothing if the contacts that would bounce have these colours (bits). A sweep changes nothing
    // before its first contact that bounces, so skipping it changes no bit.
    int left_out(std::uint8_t colours) const { return colours == 0 ? bounce_stages : std::countr_zero(colours); }
};

// How a sweep changes the impulses of contacts. A contact with a gap may close no faster than gap * apart_rate. An overlapping contact
// should open at gap * overlap_rate, at most at max_depenetration_speed or at load_rate times the speed that its impulse gives both bodies,
// whichever is more: a body that is pressed into another needs the push to stay where it is; one that started there would fly off.
struct SweepRule {
    float apart_rate;
    float overlap_rate;
    float max_depenetration_speed;
    float load_rate = 0;
    // Latches close gaps and open overlaps at most at this speed.
    float max_latch_speed = 0;
    // Softness of overlapping contacts: the step is scaled by mass_scale, and impulse_scale of the impulse is taken back.
    float mass_scale = 1;
    float impulse_scale = 0;
    float over_relaxation = 1;
};

struct MoveRule {
    float step_s;
    float gravity[3];
    // The factors by which damping scales the velocities in a step.
    float linear_kept = 1, angular_kept = 1;
};

// Which contacts bounce: those that approach faster than `min_speed` and whose gap closes within the substep, but for `margin`. What
// accelerates bodies on the rest of their way to each other: gravity and wrenches, by slot (null: none; two sets are added).
struct BounceRule {
    float min_speed, step_s, margin;
    float gravity[3];
    const Wrench* wrenches[2] = {nullptr, nullptr};
};

// The rules for the passes of a step, from the settings, its times and the diameter of the smallest body.
struct Rules {
    SweepRule solve, relax;
    MoveRule move;
    BounceRule bounce;
};
Rules rules_for(const Settings& settings, const StepTimes& times, double diameter_m);

}  // namespace meld::physics
