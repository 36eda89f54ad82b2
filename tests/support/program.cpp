#include "tests/support/program.hpp"
#include "tests/support/paths.hpp"

#include <fcntl.h>
#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <thread>

#include "tests/support/temporary.hpp"

namespace trammel::tests {

namespace {

[[noreturn]] void execute(std::vector<std::string> words) {
  std::string program = tests::build_folder() + "/trammel";
  std::vector<char*> arguments = {program.data()};
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execv(arguments[0], arguments.data());
  _exit(127);
}

[[noreturn]] void become_program(const std::vector<std::string>& words, const std::string& folder,
                                 const std::string& out, const std::string& err) {
  const int flags = O_WRONLY | O_CREAT | O_TRUNC;
  const bool ready = chdir(folder.c_str()) == 0 && dup2(open("/dev/null", O_RDONLY), 0) == 0 &&
                     dup2(open(out.c_str(), flags, 0600), 1) == 1 &&
                     dup2(open(err.c_str(), flags, 0600), 2) == 2 && unsetenv("TRAMMEL_DB") == 0;
  if (ready) execute(words);
  _exit(127);
}

}  // namespace

Finished run_program(const std::vector<std::string>& words, const std::filesystem::path& folder,
                     std::optional<int> kill_after_ms) {
  const TemporaryFolder files;
  const std::string out = files.path() / "out", err = files.path() / "err";
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("fork");
  if (child == 0) become_program(words, folder, out, err);
  if (kill_after_ms) {
    std::this_thread::sleep_for(std::chrono::milliseconds(*kill_after_ms));
    kill(child, SIGKILL);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_text(out), read_text(err)};
}

std::string run_on_terminal(const std::vector<std::string>& words,
                            const std::filesystem::path& folder, bool no_color) {
  int terminal = -1;
  const pid_t child = forkpty(&terminal, nullptr, nullptr, nullptr);
  if (child < 0) throw std::runtime_error("forkpty");
  if (child == 0) {
    if (chdir(folder.c_str()) != 0) _exit(127);
    no_color ? setenv("NO_COLOR", "1", 1) : unsetenv("NO_COLOR");
    execute(words);
  }
  std::string text;
  char buffer[4096];
  // The terminal answers EIO once the program has gone.
  for (ssize_t n = 0; (n = read(terminal, buffer, sizeof buffer)) > 0;) {
    text.append(buffer, static_cast<std::size_t>(n));
  }
  close(terminal);
  waitpid(child, nullptr, 0);
  return text;
}

}  // namespace trammel::tests
