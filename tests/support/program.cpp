#include "tests/support/program.hpp"
#include "tests/support/paths.hpp"

#include <fcntl.h>
#include <pty.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <thread>

#include "tests/support/temporary.hpp"

namespace trammel::tests {

namespace {

/// A program by its path, or its name on PATH, and its arguments. Where the program under test
/// draws with blocks must not depend on who runs the tests.
[[noreturn]] void execute(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  setenv("LC_ALL", "C.UTF-8", 1);
  setenv("TERM", "xterm", 1);
  execvp(arguments[0], arguments.data());
  _exit(127);
}

std::vector<std::string> trammel(std::vector<std::string> words) {
  words.insert(words.begin(), tests::build_folder() + "/trammel");
  return words;
}

[[noreturn]] void become(const std::vector<std::string>& words, const std::string& folder, int out,
                         int err) {
  const bool ready = chdir(folder.c_str()) == 0 && dup2(open("/dev/null", O_RDONLY), 0) == 0 &&
                     dup2(out, 1) == 1 && dup2(err, 2) == 2 && unsetenv("TRAMMEL_DB") == 0;
  if (ready) execute(words);
  _exit(127);
}

int file_for_writing(const std::string& path) {
  return open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
}

int exit_code_of(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : -1; }

Finished run(const std::vector<std::string>& words, const std::filesystem::path& folder,
             std::optional<int> kill_after_ms) {
  const TemporaryFolder files;
  const std::string out = files.path() / "out", err = files.path() / "err";
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("fork");
  if (child == 0) become(words, folder, file_for_writing(out), file_for_writing(err));
  if (kill_after_ms) {
    std::this_thread::sleep_for(std::chrono::milliseconds(*kill_after_ms));
    kill(child, SIGKILL);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return {exit_code_of(status), read_text(out), read_text(err)};
}

}  // namespace

Finished run_program(const std::vector<std::string>& words, const std::filesystem::path& folder,
                     std::optional<int> kill_after_ms) {
  return run(trammel(words), folder, kill_after_ms);
}

Finished run_command(const std::vector<std::string>& words, const std::filesystem::path& folder) {
  return run(words, folder, {});
}

Served::Served(const std::vector<std::string>& words, const std::filesystem::path& folder) {
  int ends[2] = {-1, -1};
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("pipe");
  out_ = ends[0];
  child_ = fork();
  if (child_ < 0) throw std::runtime_error("fork");
  if (child_ == 0) {
    become(trammel(words), folder, ends[1], file_for_writing(files_.path() / "err"));
  }
  close(ends[1]);
}

Served::~Served() {
  if (child_ >= 0) {
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
  }
  close(out_);
}

std::string Served::first_line() {
  char c = 0;
  while (read_.find('\n') == std::string::npos && read(out_, &c, 1) == 1) read_ += c;
  return read_.substr(0, read_.find('\n'));
}

Finished Served::stop(int signal) {
  kill(child_, signal);
  for (char c = 0; read(out_, &c, 1) == 1;) read_ += c;
  int status = 0;
  waitpid(child_, &status, 0);
  child_ = -1;
  return {exit_code_of(status), read_, read_text(files_.path() / "err")};
}

std::string run_on_terminal(const std::vector<std::string>& words,
                            const std::filesystem::path& folder, bool no_color, int columns) {
  int terminal = -1;
  winsize size{};
  size.ws_col = static_cast<unsigned short>(columns);
  size.ws_row = 40;
  const pid_t child = forkpty(&terminal, nullptr, nullptr, &size);
  if (child < 0) throw std::runtime_error("forkpty");
  if (child == 0) {
    if (chdir(folder.c_str()) != 0) _exit(127);
    no_color ? setenv("NO_COLOR", "1", 1) : unsetenv("NO_COLOR");
    execute(trammel(words));
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
