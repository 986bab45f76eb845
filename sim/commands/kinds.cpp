#include "sim/commands/kinds.h"

#include "sim/commands/table.h"

namespace limberg {

bool cuts_skin(const Command& command) {
  return visit_act(command, []<class C>(const C&) {
    return requires { requires Act<C>::cuts_skin; };
  });
}

bool sews(const Command& command) {
  return visit_act(command, []<class C>(const C&) {
    return requires { requires Act<C>::sews; };
  });
}

bool is_of_hooks(const Command& command) {
  return std::holds_alternative<SetHook>(command) || std::holds_alternative<MoveHook>(command) ||
         std::holds_alternative<ReleaseHook>(command);
}

bool is_of_pen(const Command& command) {
  return visit_act(command, []<class C>(const C&) { return std::is_same_v<C, Mark>; });
}

bool looks_back(const Command& command) {
  return visit_act(command, []<class C>(const C&) {
    return requires { requires Act<C>::looks_back; };
  });
}

bool leaves_patient(const Command& command) {
  return visit_act(command, []<class C>(const C&) {
    return requires { requires Act<C>::leaves_patient; };
  });
}

}  // namespace limberg
