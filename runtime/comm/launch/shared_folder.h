// A folder in memory of one run, in which Open MPI's processes exchange messages: whatever a killed run leaves there goes with it.
#pragma once

#include <string>

namespace meld::comm {

class SharedFolder {
  public:
    // Makes the folder where Open MPI would put its files, and removes those of runs whose supervisor was killed. Without effect if none
    // can be made.
    SharedFolder();
    ~SharedFolder();
    SharedFolder(const SharedFolder&) = delete;
    SharedFolder& operator=(const SharedFolder&) = delete;

    // The variable that tells Open MPI of it; its own default is used where path() is empty.
    static constexpr const char* kVariable = "OMPI_MCA_btl_vader_backing_directory";
    const std::string& path() const { return path_; }

  private:
    std::string path_;
    int descriptor_ = -1;  // Locked as long as this process lives.
};

}  // namespace meld::comm
