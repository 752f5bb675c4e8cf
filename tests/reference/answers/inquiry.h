// Asks the run of a trial at random ticks: why facts hold, why others do not, and a question; and judges the answers.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/reference/answers/judge.h"
#include "tests/reference/trials/run.h"

namespace meld::reference {

struct Inquiry {
    AskedFor asked;
    enum class Kind { Why, WhyNot, Query } kind = Kind::Why;
    nlohmann::ordered_json answer = {};
    std::string error = {};
    std::string trouble = {};  // Of the answer to a query, which is compared with the reference's at once.
};

// A run's past, and what was asked of it.
struct Inquiries {
    std::unique_ptr<Past> past;
    std::vector<Inquiry> all;
    std::uint64_t rows = 0;  // Of answers to queries.
};

// So many facts that hold, and as many that do not, on so many processes. The trial and the program outlive it.
Inquiries inquire(const Trial& trial, const check::Program& program, const ModuleInfo& module, int processes, int count);

// What is wrong with an answer; empty: nothing.
std::string judge(const Past& past, const Inquiry& inquiry, Judged& judged);

// Falsifies an answer in one place. Returns what it has done; empty: there is nothing that could be changed in this way.
std::string falsify(retraction::Random& random, Inquiry& inquiry);

struct InquiryTally {
    std::uint64_t why = 0, why_not = 0, queries = 0, rows = 0;
    std::uint64_t falsified = 0;  // Answers that were changed, each of which was refused.
    Judged judged = {};
    void add(const InquiryTally& other);
};

// All of it; returns the trouble, or nothing.
std::string trouble_of_inquiries(const Trial& trial, const check::Program& program, const ModuleInfo& module, int processes, int count,
                                 InquiryTally& tally);

}  // namespace meld::reference
