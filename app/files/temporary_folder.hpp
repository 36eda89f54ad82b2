#pragma once
// A folder that goes again.

#include <filesystem>

namespace trammel {

/// An empty folder of this process under the system's folder for such, removed with all that is in
/// it. Throws StoreError where none can be made. Proof: work_test.cpp and demo_test.cpp use it.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace trammel
