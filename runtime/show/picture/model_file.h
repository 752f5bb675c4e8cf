// Files for other programs, of what is shown of a run: tables and points with values, and solids with colours.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "runtime/base/error.h"
#include "runtime/base/files/output_file.h"
#include "runtime/show/picture/frame.h"

namespace meld::picture {

class ModelFile {
  public:
    // Whether files of this name can hold so many ticks. Errors: the name ends with nothing that is known; it holds one tick only, and the
    // name has no TICK in it.
    static Result<void> check(const std::string& path, std::size_t ticks);
    // Errors: those of check(), and of the file, which is seen when it is whole only. A name with TICK stands for a file of each tick.
    static Result<std::unique_ptr<ModelFile>> open(const std::string& path, std::size_t ticks);
    virtual ~ModelFile() = default;
    ModelFile(const ModelFile&) = delete;
    ModelFile& operator=(const ModelFile&) = delete;

    // A frame with its colours. Errors: it is too large for the format (4).
    virtual Result<void> add(const Frame& frame) = 0;
    virtual Result<void> commit() = 0;

  protected:
    ModelFile() = default;
};

}  // namespace meld::picture
