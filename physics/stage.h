// What a step is made of: its times, the stages it is taken in, and the numbers that its passes go by.
#pragma once

#include <bit>
#include <cstdint>

namespace meld::physics {

struct Settings;

inline constexpr int kColours = 8;

struct StepTimes {
    double dt_s;
    int substeps;
    double substep_s() const { return dt_s / substeps; }
};

struct Stage {
    enum class Kind {
        // Candidate list if needed, copy of the state, which blocks may sleep.
        Prepare,
        // Blocks fall asleep or wake; gaps and normals are computed again if they are not up to date.
        UpdateSleep,
        // Magnets and plates of the blocks of a colour.
        Actuate,
        // Gravity, wrenches and damping.
        Accelerate,
        // By colour: the kept impulses; a sweep; a sweep that relaxes.
        WarmStart,
        Solve,
        Relax,
        // Which colours have contacts that would bounce now; then, by colour, a sweep of restitution.
        FindBounces,
        Bounce,
        Move,
        Refresh,
        // Touch events and the end of the tick.
        Finish,
    };
    Kind kind;
    int colour = -1;
    // Of FindBounces: how many stages follow that do nothing if nothing bounces.
    int bounce_stages = 0;

    // Whether other subdomains must receive its results before the next stage (subdomain.h).
    bool must_exchange() const { return colour >= 0 || kind == Kind::Prepare; }
    // Whether the subdomains must join what they found in it, and then leave out stages.
    bool must_agree() const { return kind == Kind::FindBounces; }
    // How many of the following stages do nothing, where these colours (bits) have contacts that would bounce. A sweep changes nothing
    // before its first contact that bounces; so what is left out changes no bit.
    int left_out(std::uint8_t colours) const { return colours == 0 ? bounce_stages : std::countr_zero(colours); }
};

// How a sweep moves the impulses of contacts. A contact `gap` apart is asked to close no faster than gap * apart_rate; one
// that overlaps to open at gap * overlap_rate, at most at max_depenetration_speed, or at load_rate times the speed that its impulse gives
// both bodies, if that is more: what is pressed into another needs the push to stay where it is, what started there would fly off.
struct SweepRule {
    float apart_rate;
    float overlap_rate;
    float max_depenetration_speed;
    float load_rate = 0;
    // Latches close gaps and open overlaps no faster.
    float max_latch_speed = 0;
    // Softness of overlapping contacts: the step is scaled by mass_scale, and impulse_scale of the impulse is taken back.
    float mass_scale = 1;
    float impulse_scale = 0;
    float over_relaxation = 1;
};

struct MoveRule {
    float step_s;
    float gravity[3];
    // Factors that damping leaves of the velocities in a step.
    float linear_kept = 1, angular_kept = 1;
};

// Which contacts bounce: those that approach faster than `min_speed` and whose gap closes within the substep, but for `margin`.
struct BounceRule {
    float min_speed, step_s, margin;
};

// The rules of a step's passes, from the settings, its times and the diameter of the smallest body.
struct Rules {
    SweepRule solve, relax;
    MoveRule move;
    BounceRule bounce;
};
Rules rules_for(const Settings& settings, const StepTimes& times, double diameter_m);

}  // namespace meld::physics
