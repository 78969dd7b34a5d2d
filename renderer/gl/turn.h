// Contexts of software drivers take turns at GL.
//
// Mesa gives all contexts of a display (and of OSMesa) one screen, and whatever maps a resource in one of them walks
// what all of them draw into and read (llvmpipe_flush_resource), while their threads change and free it: without a lock
// in Mesa 22.3, with some in later ones. So of these contexts one thread at a time is in GL. Drivers of hardware lock
// for themselves.
#pragma once

namespace halfshade::gl {

class Context;

class Turn {
 public:
  // Waits until those who asked before have had theirs. A thread that has the turn already keeps it. `is_needed`:
  // false where the context's driver is known to do without.
  explicit Turn(bool is_needed = true);
  explicit Turn(const Context& context);
  ~Turn();
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

 private:
  bool is_taken_;
};

// Lets those who wait have theirs first, where the calling thread has the turn: between submissions.
void PassTurn();

// No GL in this scope: others may have the turn meanwhile, and it is taken again at the end.
class TurnPause {
 public:
  TurnPause();
  ~TurnPause();
  TurnPause(const TurnPause&) = delete;
  TurnPause& operator=(const TurnPause&) = delete;

 private:
  bool had_turn_;
};

}  // namespace halfshade::gl
