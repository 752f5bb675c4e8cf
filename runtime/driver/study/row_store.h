// What a folder of results keeps of the runs of a study, for any number of processes on any number of machines that share it.
//
// Nothing depends on locks. Each process appends the rows that it has made to a journal of its own, journals/HOST-PID.jsonl.
// Before it makes a row it creates the symbolic link claims/KEY to its own name, which file systems over a network do in one step
// too: there is no moment in which a claim does not say whose it is. Who does not succeed takes another row. A claim counts as long
// as its owner lives, which touches its journal every few seconds.
// Should two make the same row all the same, that is lost time and nothing else: the rows are the same, bit for bit.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/driver/study/row_run.h"

namespace meld::driver {

// The folder of the results of a study: this one, if it is not empty, or that beside the study.
std::string results_folder(const std::string& study, const std::string& folder);

class RowStore {
  public:
    // Makes the folder, and a journal in it when there is something to write. Errors: it cannot be written.
    static Result<RowStore> open(const std::string& folder);
    RowStore(RowStore&& other) noexcept;
    RowStore& operator=(RowStore&&) = delete;
    // Takes back its claims of rows that it has not made.
    ~RowStore();

    const std::string& folder() const { return folder_; }
    std::string worlds_folder() const { return folder_ + "/worlds"; }

    // Reads what others have added to their journals.
    void refresh();
    // The row, if it has everything that the study asks for; whenever it was asked for what.
    const RowResult* find(const StudyRow& row, const Study& study) const;
    // The result of a row, whatever it has.
    const RowResult* any(const StudyRow& row) const;

    // Whether this process is to make the row. Errors: the folder cannot be written.
    Result<bool> claim(const StudyRow& row);
    // Takes a claim back.
    void release(const StudyRow& row);
    // Adds a row. Errors: the disk is full.
    Result<void> add(const StudyRow& row, const RowResult& result);
    // Shows the others that this process lives; cheap, to be called often.
    void beat();
    // Rows of the plan that have failed, as this study sees it, count as not made.
    void forget(const StudyRow& row) { results_.erase(row.key); }
    // Removes the claims of rows that are made.
    void clean();

  private:
    RowStore() = default;
    Result<void> begin_journal();
    bool owner_lives(const std::string& owner) const;
    std::string claim_path(const StudyRow& row) const { return folder_ + "/claims/" + row.key; }
    void keep(const std::string& key, RowResult result);
    void read_journal(const std::string& path);

    std::string folder_, name_;  // HOST-PID
    std::string journal_path_;
    int journal_ = -1;
    double next_beat_ = 0;
    std::map<std::string, std::uint64_t> read_;  // Bytes of each journal, to the end of a line.
    std::map<std::string, RowResult> results_;   // By key.
    std::map<std::string, bool> claimed_;        // Keys that this process has claimed and not made.
};

}  // namespace meld::driver
