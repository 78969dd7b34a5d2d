// In libFuzzer's place where the compiler has none: every file below the arguments, whole, cut and with bytes changed,
// through LLVMFuzzerTestOneInput. A folder that is not there has no files.
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace {

namespace fs = std::filesystem;

constexpr int kChanges = 20;
constexpr uintmax_t kMaxBytes = 64 << 10;

void Run(const std::string& bytes) {
  LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
}

}  // namespace

int main(int argc, char** argv) {
  std::mt19937 random(1);
  int count = 0;
  Run("");
  for (int i = 1; i < argc; ++i) {
    std::error_code error;
    for (const auto& entry : fs::recursive_directory_iterator(argv[i], error)) {
      if (!entry.is_regular_file() || entry.file_size() > kMaxBytes) continue;
      std::ifstream file(entry.path(), std::ios::binary);
      std::ostringstream text;
      text << file.rdbuf();
      const std::string bytes = text.str();
      Run(bytes);
      ++count;
      for (int change = 0; change < kChanges && !bytes.empty(); ++change) {
        std::string changed = bytes;
        for (int c = 0; c < 1 + change / 4; ++c) changed[random() % changed.size()] = char(random());
        if (change % 5 == 4) changed.resize(random() % changed.size());
        Run(changed);
      }
    }
  }
  std::printf("%d files and %d changes of each\n", count, kChanges);
  return 0;
}
