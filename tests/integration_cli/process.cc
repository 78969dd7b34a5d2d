#include "tests/integration_cli/process.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <utility>

#include "tests/client/temporary_folder.h"

namespace halfshade {
namespace {

// Ours without HALFSHADE_SERVER.
std::vector<char*> Environment() {
  std::vector<char*> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    if (std::strncmp(*variable, "HALFSHADE_SERVER=", 17) != 0) variables.push_back(*variable);
  }
  variables.push_back(nullptr);
  return variables;
}

pid_t Spawn(const std::string& binary, const std::vector<std::string>& arguments, posix_spawn_file_actions_t* actions) {
  std::vector<char*> argv = {const_cast<char*>(binary.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  std::vector<char*> variables = Environment();
  pid_t pid = -1;
  const int error = posix_spawn(&pid, binary.c_str(), actions, nullptr, argv.data(), variables.data());
  posix_spawn_file_actions_destroy(actions);
  if (error != 0) ADD_FAILURE() << binary << ": " << std::strerror(error);
  return error == 0 ? pid : -1;
}

bool IsRunning(pid_t pid) {
  siginfo_t info{};
  return pid > 0 && waitid(P_PID, static_cast<id_t>(pid), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == 0;
}

int WaitFor(pid_t pid) {
  int status = 0;
  if (pid < 0 || waitpid(pid, &status, 0) != pid) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

Ran RunHalfshade(const std::vector<std::string>& arguments, const std::string& folder) {
  const TemporaryFolder streams;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, (streams / "out").c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, (streams / "err").c_str(), O_WRONLY | O_CREAT, 0600);
  Ran ran;
  ran.exit_code = WaitFor(Spawn(HALFSHADE_BINARY, arguments, &actions));
  ran.out = ReadAll(streams / "out");
  ran.err = ReadAll(streams / "err");
  return ran;
}

ClientProcess::ClientProcess(const std::vector<std::string>& arguments, const std::string& folder) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&actions, stream, "/dev/null", O_RDWR, 0);
  }
  pid_ = Spawn(HALFSHADE_BINARY, arguments, &actions);
}

ClientProcess::~ClientProcess() { Kill(); }

bool ClientProcess::IsAlive() const { return IsRunning(pid_); }

int ClientProcess::Wait() { return WaitFor(std::exchange(pid_, -1)); }

void ClientProcess::Kill() {
  if (pid_ < 0) return;
  kill(pid_, SIGKILL);
  Wait();
}

ServerProcess::ServerProcess(const std::vector<std::string>& arguments) {
  int out[2];
  if (pipe2(out, O_CLOEXEC) != 0) return;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
  std::vector<std::string> all = {"--http", "off"};
  if (std::find(arguments.begin(), arguments.end(), "--listen") == arguments.end()) {
    all.insert(all.end(), {"--listen", "127.0.0.1:0"});
  }
  all.insert(all.end(), arguments.begin(), arguments.end());
  pid_ = Spawn(HALFSHADED_BINARY, all, &actions);
  close(out[1]);
  // "serving grpc=127.0.0.1:41234 http=off"
  std::string line;
  for (char c = 0; read(out[0], &c, 1) == 1 && c != '\n';) line += c;
  close(out[0]);
  const auto word_after = [&line](const std::string& name) {
    const size_t start = line.find(name + "=");
    return start == std::string::npos
               ? ""
               : line.substr(start + name.size() + 1, line.find(' ', start) - start - name.size() - 1);
  };
  address_ = word_after("grpc");
  admin_ = word_after("admin");
  EXPECT_NE(address_, "") << "halfshaded said '" << line << "'";
}

ServerProcess::~ServerProcess() { Stop(); }

bool ServerProcess::IsAlive() const { return IsRunning(pid_); }

void ServerProcess::Signal(int signal) const {
  if (pid_ > 0) kill(pid_, signal);
}

int ServerProcess::Wait() {
  if (pid_ < 0) return -1;
  const int exit_code = WaitFor(pid_);
  pid_ = -1;
  return exit_code;
}

int ServerProcess::Stop() {
  Signal(SIGTERM);
  return Wait();
}

double ServerProcess::PeakMemoryMb() const {
  std::ifstream status("/proc/" + std::to_string(pid_) + "/status");
  for (std::string word; status >> word;) {
    double kb = 0;
    if (word == "VmHWM:" && status >> kb) return kb / 1e3;
  }
  return 0;
}

void ServerProcess::Kill() {
  if (pid_ < 0) return;
  kill(pid_, SIGKILL);
  Wait();
}

}  // namespace halfshade
