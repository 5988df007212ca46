/* simcore's bridge: an extension of WPILib's simulated HAL that lets another process step a robot program.
 *
 * It links to nothing of WPILib: every function is looked up in the running program, whatever language that is written
 * in. HALSIM_InitExtension pauses the program's clock; a thread connects to 127.0.0.1:$SIMCORE_PORT (9810), and for each
 * frame from there it writes sensors and driver station, steps the clock, and answers with what has changed.
 * docs/bridge.md describes the frames. The rows of INPUTS and OUTPUTS are those of packets.py, in the same order.
 */
#define _GNU_SOURCE
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef _WIN32
#include <winsock2.h>
#include <windows.h>
#define EXPORT __declspec(dllexport)
typedef SOCKET socket_t;
#define close_socket closesocket
#define sleep_ms Sleep
#else
#include <arpa/inet.h>
#include <dlfcn.h>
#include <netinet/tcp.h>
#include <pthread.h>
#include <sys/socket.h>
#include <unistd.h>
#ifdef __APPLE__
#include <mach-o/dyld.h>
#else
#include <link.h>
#endif
#define EXPORT __attribute__((visibility("default")))
#define INVALID_SOCKET (-1)
typedef int socket_t;
#define close_socket close
#define sleep_ms(ms) usleep((ms) * 1000)
#endif

#define VERSION '1'
#define PORT 9810
#define PATIENCE 60 /* [s] in which simcore may start */
#define LARGEST (1 << 20) /* bytes of a frame */
#define VALUES 2048 /* of SimDevices */
#define FIRST_TEXT 128 /* kinds from here on carry text, `size` bytes behind the record */

struct header { char magic[4]; uint32_t size; uint64_t time; }; /* `size` bytes of records follow; time in microseconds */
struct record { uint8_t kind, sub; uint16_t size; int32_t number; double value; };
struct text { const char *str; size_t len; }; /* WPI_String */
struct sim_value { union { int32_t i; int64_t l; double d; } data; int32_t type; }; /* HAL_Value */
enum { TYPE_DOUBLE = 2, TYPE_LONG = 16 };

/* --- functions of the program ------------------------------------------------------------------------------------- */

#ifdef _WIN32
static void *find(const char *name) {
  const char *modules[] = {"wpiHal.dll", "wpiHald.dll", "ntcore.dll", "ntcored.dll", "wpiutil.dll", "wpiutild.dll", NULL};
  for (int i = 0; i < 7; i++) {
    HMODULE module = GetModuleHandleA(modules[i]);
    void *found = module ? (void *)GetProcAddress(module, name) : NULL;
    if (found) return found;
  }
  return NULL;
}
#else
/* Java and Python load WPILib for themselves alone (RTLD_LOCAL), so its libraries are asked one by one. */
static void *find_in(const char *path, const char *name) {
  const char *file = path ? strrchr(path, '/') : NULL;
  if (!file || !(strstr(file, "wpiHal") || strstr(file, "ntcore") || strstr(file, "wpiutil"))) return NULL;
  void *library = dlopen(path, RTLD_LAZY | RTLD_NOLOAD);
  return library ? dlsym(library, name) : NULL;
}
#ifdef __APPLE__
static void *find(const char *name) {
  void *found = dlsym(RTLD_DEFAULT, name);
  for (uint32_t i = 0; !found && i < _dyld_image_count(); i++) found = find_in(_dyld_get_image_name(i), name);
  return found;
}
#else
struct search { const char *name; const char *paths[256]; int count; };
static int note_path(struct dl_phdr_info *info, size_t size, void *p) {
  struct search *search = p;
  (void)size;
  if (search->count < 256 && info->dlpi_name && strchr(info->dlpi_name, '/') && strstr(info->dlpi_name, ".so"))
    if (strstr(info->dlpi_name, "wpi") || strstr(info->dlpi_name, "ntcore")) search->paths[search->count++] = info->dlpi_name;
  return 0;
}
static void *find(const char *name) {
  static struct search search;
  void *found = dlsym(RTLD_DEFAULT, name);
  if (!found && !search.count) dl_iterate_phdr(note_path, &search);
  for (int i = 0; !found && i < search.count; i++) found = find_in(search.paths[i], name);
  return found;
}
#endif
#endif

typedef void (*step_f)(uint64_t);
typedef uint64_t (*time_f)(int32_t *);
typedef void (*plain_f)(void);
typedef void (*device_f)(const char *, void *, int32_t);
typedef void (*value_f)(const char *, void *, int32_t, int32_t, const struct sim_value *);
typedef int32_t (*error_f)(int32_t, int32_t, int32_t, const char *, const char *, const char *, int32_t);
static plain_f pause_clock, resume_clock, new_data;
static step_f step_clock;
static time_f fpga_time;
static void (*each_device)(const char *, void *, device_f), (*each_value)(int32_t, void *, value_f);
static void (*get_value)(int32_t, struct sim_value *), (*set_value)(int32_t, const struct sim_value *);
static void (*set_error)(error_f);
static int32_t (*tables)(void);
static int32_t *(*topics)(int32_t, const struct text *, unsigned, size_t *);
static void (*topic_name)(int32_t, struct text *), (*get_string)(int32_t, const struct text *, struct text *);
static int32_t (*entry)(int32_t, const struct text *), (*set_string)(int32_t, int64_t, const struct text *);
static struct text *(*get_strings)(int32_t, const struct text *, size_t, size_t *);
static void (*free_text)(const struct text *), (*free_texts)(const struct text *, size_t);
static const struct { const char *name; void *place; } FUNCTIONS[] = {
  {"HALSIM_PauseTiming", &pause_clock}, {"HALSIM_ResumeTiming", &resume_clock}, {"HALSIM_StepTiming", &step_clock},
  {"HALSIM_NotifyDriverStationNewData", &new_data}, {"HAL_GetFPGATime", &fpga_time},
  {"HALSIM_EnumerateSimDevices", &each_device}, {"HALSIM_EnumerateSimValues", &each_value},
  {"HAL_GetSimValue", &get_value}, {"HAL_SetSimValue", &set_value}, {"HALSIM_SetSendError", &set_error},
  {NULL, NULL}, /* those of NetworkTables, which a program may do without */
  {"NT_GetDefaultInstance", &tables}, {"NT_GetTopics", &topics}, {"NT_GetTopicName", &topic_name},
  {"NT_GetString", &get_string}, {"NT_GetEntry", &entry}, {"NT_SetString", &set_string},
  {"NT_GetStringArray", &get_strings}, {"WPI_FreeString", &free_text}, {"WPI_FreeStringArray", &free_texts},
};

/* Calls by what a function takes: index (N), second index (S), integer (I), number (D), text (T). */
enum call { I, D, NI, ND, NSI, NSD, T };
static struct { enum call call; const char *name; void *f; } INPUTS[] = {
  {D, "SetRoboRioVInVoltage"}, {I, "SetDriverStationEnabled"}, {I, "SetDriverStationAutonomous"},
  {I, "SetDriverStationTest"}, {I, "SetDriverStationEStop"}, {I, "SetDriverStationFmsAttached"},
  {I, "SetDriverStationDsAttached"}, {I, "SetDriverStationAllianceStationId"}, {D, "SetDriverStationMatchTime"},
  {I, "SetMatchType"}, {I, "SetMatchNumber"}, {I, "SetReplayNumber"},
  {NI, "SetJoystickAxisCount"}, {NI, "SetJoystickPOVCount"}, {NI, "SetJoystickButtonCount"},
  {NSD, "SetJoystickAxis"}, {NSI, "SetJoystickPOV"}, {NI, "SetJoystickButtonsValue"},
  {NI, "SetEncoderCount"}, {ND, "SetEncoderPeriod"}, {NI, "SetEncoderDirection"}, {NI, "SetDIOValue"},
  {ND, "SetAnalogInVoltage"}, {ND, "SetDutyCycleOutput"}, {ND, "SetAnalogGyroAngle"}, {ND, "SetAnalogGyroRate"},
};
static struct { enum call call; const char *name; void *f; } TEXTS[] = {{T, "SetGameSpecificMessage"}, {T, "SetEventName"}};

/* Values that are polled: so many of each, with so many second ones where the row before says that it is in use. */
static struct { enum call call; int count, subs; const char *name; void *f; int first; } OUTPUTS[] = {
  {I, 1, 1, "GetProgramStarted"}, {I, 1, 1, "GetDriverStationEnabled"}, {I, 1, 1, "GetDriverStationAutonomous"},
  {I, 1, 1, "GetDriverStationTest"}, {I, 1, 1, "GetDriverStationAllianceStationId"},
  {NI, 20, 1, "GetPWMInitialized"}, {ND, 20, 1, "GetPWMSpeed"}, {ND, 20, 1, "GetPWMPosition"},
  {NI, 20, 1, "GetPWMPulseMicrosecond"},
  {NI, 31, 1, "GetDIOInitialized"}, {NI, 31, 1, "GetDIOIsInput"}, {NI, 31, 1, "GetDIOValue"},
  {NI, 8, 1, "GetAnalogInInitialized"}, {NI, 2, 1, "GetAnalogGyroInitialized"}, {ND, 2, 1, "GetAnalogGyroAngle"},
  {NI, 4, 1, "GetRelayInitializedForward"}, {NI, 4, 1, "GetRelayInitializedReverse"},
  {NI, 4, 1, "GetRelayForward"}, {NI, 4, 1, "GetRelayReverse"},
  {NI, 8, 1, "GetEncoderDigitalChannelA"}, {NI, 8, 1, "GetEncoderDigitalChannelB"},
  {NI, 8, 1, "GetEncoderInitialized"}, {ND, 8, 1, "GetEncoderDistancePerPulse"}, {NI, 8, 1, "GetEncoderReset"},
  {NI, 8, 1, "GetDutyCycleDigitalChannel"}, {NI, 8, 1, "GetDutyCycleInitialized"},
  {NI, 63, 1, "GetCTREPCMInitialized"}, {NSI, 63, 8, "GetCTREPCMSolenoidOutput"},
  {NI, 63, 1, "GetREVPHInitialized"}, {NSI, 63, 16, "GetREVPHSolenoidOutput"},
};
#define ROWS(table) ((int)(sizeof table / sizeof *table))
enum { SIM_VALUE = 100, NEW_DATA = 101, CLOCK = 102, END = 103, LOOK = 104 }; /* kinds beside INPUTS and OUTPUTS */
enum { SELECT = FIRST_TEXT + 10, GOODBYE = FIRST_TEXT + 11 };                             /* texts beside TEXTS */
enum { VALUE_NAME = FIRST_TEXT, CHOOSER = FIRST_TEXT + 1, ERROR_TEXT = FIRST_TEXT + 2, PROCESS = 105 };

static int complain(const char *sentence, const char *name) {
  fprintf(stderr, "simcore: %s%s\n", sentence, name);
  fflush(stderr);
  return -1;
}

static void *halsim(const char *name) {
  char full[64];
  snprintf(full, sizeof full, "HALSIM_%s", name);
  return find(full);
}

static int look_up(void) {
  int first = 0, is_needed = 1;
  for (int i = 0; i < ROWS(FUNCTIONS); i++) {
    if (!FUNCTIONS[i].name) { is_needed = 0; continue; }
    void *found = find(FUNCTIONS[i].name);
    if (!found && is_needed) return complain("this program's WPILib is not that of 2026, it has no ", FUNCTIONS[i].name);
    memcpy(FUNCTIONS[i].place, &found, sizeof found);
  }
  for (int i = 0; i < ROWS(INPUTS); i++) INPUTS[i].f = halsim(INPUTS[i].name);
  for (int i = 0; i < ROWS(TEXTS); i++) TEXTS[i].f = halsim(TEXTS[i].name);
  for (int i = 0; i < ROWS(OUTPUTS); i++) {
    OUTPUTS[i].f = halsim(OUTPUTS[i].name);
    OUTPUTS[i].first = first;
    first += OUTPUTS[i].count * OUTPUTS[i].subs;
  }
  return 0;
}

/* --- what the program does ---------------------------------------------------------------------------------------- */

static char frame[LARGEST + 65536];
static size_t length;
static double polled[4096]; /* as they were sent last */
static struct { int32_t handle; double value; } values[VALUES];
static int count_values, next_value;
static char errors[16384]; /* texts, each with a zero behind it */
static size_t errors_length;
#ifdef _WIN32
static CRITICAL_SECTION errors_lock;
#define LOCK() EnterCriticalSection(&errors_lock)
#define UNLOCK() LeaveCriticalSection(&errors_lock)
#else
static pthread_mutex_t errors_lock = PTHREAD_MUTEX_INITIALIZER;
#define LOCK() pthread_mutex_lock(&errors_lock)
#define UNLOCK() pthread_mutex_unlock(&errors_lock)
#endif

static void put(int kind, int sub, int32_t number, double value, const char *text, size_t size) {
  struct record record = {(uint8_t)kind, (uint8_t)sub, (uint16_t)size, number, value};
  if (size > 65535 || length + sizeof record + size > sizeof frame) return;
  memcpy(frame + length, &record, sizeof record);
  if (size) memcpy(frame + length + sizeof record, text, size);
  length += sizeof record + size;
}

static void poll_ports(void) {
  for (int row = 0; row < ROWS(OUTPUTS); row++) {
    void *f = OUTPUTS[row].f;
    for (int n = 0; f && n < OUTPUTS[row].count; n++)
      for (int s = 0; s < OUTPUTS[row].subs; s++) {
        double *last = &polled[OUTPUTS[row].first + n * OUTPUTS[row].subs + s], now;
        if (OUTPUTS[row].call == NSI && !polled[OUTPUTS[row - 1].first + n]) break;
        if (OUTPUTS[row].call == I) now = ((int32_t(*)(void))f)();
        else if (OUTPUTS[row].call == NI) now = ((int32_t(*)(int32_t))f)(n);
        else if (OUTPUTS[row].call == ND) now = ((double (*)(int32_t))f)(n);
        else now = ((int32_t(*)(int32_t, int32_t))f)(n, s);
        if (now != *last) put(row, s, n, *last = now, NULL, 0);
      }
  }
}

static double number_of(const struct sim_value *value) {
  if (value->type == TYPE_DOUBLE) return value->data.d;
  return value->type == TYPE_LONG ? (double)value->data.l : (double)value->data.i;
}

/* SimDevices are listed in the order in which they were made, so a new one is behind those that are known. */
static void poll_value(const char *name, void *device, int32_t handle, int32_t direction, const struct sim_value *value) {
  char text[512];
  double now = number_of(value);
  int row = next_value;
  (void)direction;
  if (row >= count_values || values[row].handle != handle)
    for (row = 0; row < count_values && values[row].handle != handle;) row++;
  next_value = row + 1;
  if (row == VALUES) return;
  if (row == count_values) {
    int size = snprintf(text, sizeof text, "%s%c%s", (const char *)device, 0, name);
    values[count_values++].handle = handle;
    put(VALUE_NAME, value->type, handle, now, text, size < (int)sizeof text ? (size_t)size : sizeof text - 1);
  } else if (now != values[row].value) put(SIM_VALUE, 0, handle, now, NULL, 0);
  values[row].value = now;
}

static void poll_device(const char *name, void *unused, int32_t handle) {
  (void)unused;
  each_value(handle, (void *)name, poll_value);
}

static int32_t note_error(int32_t is_error, int32_t code, int32_t is_lv, const char *details, const char *location,
                          const char *stack, int32_t prints) {
  size_t size = strlen(details) + 1;
  (void)is_lv;
  LOCK();
  if (errors_length + size <= sizeof errors) { memcpy(errors + errors_length, details, size); errors_length += size; }
  UNLOCK();
  if (prints) fprintf(stderr, "%s at %s: %s\n%s%s", is_error ? "Error" : "Warning", location, details, stack, *stack ? "\n" : "");
  (void)code;
  return 0;
}

static void put_errors(void) {
  LOCK();
  for (size_t at = 0; at < errors_length; at += strlen(errors + at) + 1) put(ERROR_TEXT, 0, 0, 0, errors + at, strlen(errors + at));
  errors_length = 0;
  UNLOCK();
}

/* --- choosers on the dashboard ------------------------------------------------------------------------------------ */

static size_t join(char *to, size_t at, size_t room, const char *text, size_t size) {
  if (at + size + 1 > room) return at;
  memcpy(to + at, text, size);
  to[at + size] = 0;
  return at + size + 1;
}

static int32_t entry_at(const char *key, size_t size, const char *name) {
  char full[512];
  int used = snprintf(full, sizeof full, "%.*s/%s", (int)size, key, name);
  struct text text = {full, used < (int)sizeof full ? (size_t)used : sizeof full - 1};
  return entry(tables(), &text);
}

static void put_choosers(void) {
  struct text prefix = {"/", 1}, nothing = {"", 0}, name, value;
  size_t count = 0, options;
  if (!tables || !topics || !get_strings || !free_texts || !free_text || !topic_name || !get_string || !entry) return;
  int32_t *found = topics(tables(), &prefix, 0, &count);
  for (size_t i = 0; i < count; i++) {
    char text[8192];
    topic_name(found[i], &name);
    size_t base = name.len - 8, at = join(text, 0, sizeof text, name.str, base);
    if (name.len > 8 && !memcmp(name.str + base, "/options", 8)) {
      const char *names[] = {".type", "default", "active"};
      for (int k = 0; k < 3; k++) {
        get_string(entry_at(name.str, base, names[k]), &nothing, &value);
        at = join(text, at, sizeof text, value.str, value.len);
        free_text(&value);
      }
      struct text *list = get_strings(entry_at(name.str, base, "options"), NULL, 0, &options);
      for (size_t k = 0; k < options; k++) at = join(text, at, sizeof text, list[k].str, list[k].len);
      if (list) free_texts(list, options);
      put(CHOOSER, 0, 0, 0, text, at - 1);
    }
    free_text(&name);
  }
}

/* --- what simcore says -------------------------------------------------------------------------------------------- */

static void write_value(int32_t handle, double number) {
  struct sim_value value;
  memset(&value, 0, sizeof value);
  get_value(handle, &value);
  if (value.type == TYPE_DOUBLE) value.data.d = number;
  else if (value.type == TYPE_LONG) value.data.l = (int64_t)number;
  else value.data.i = (int32_t)number;
  set_value(handle, &value);
  for (int row = 0; row < count_values; row++)
    if (values[row].handle == handle) values[row].value = number;
}

static void take(const struct record *r, const char *text) {
  struct text string = {text, r->size};
  int32_t n = r->number, i = (int32_t)(int64_t)r->value; /* by way of 64 bits: a button mask has no sign */
  double d = r->value;
  if (r->kind < ROWS(INPUTS) && INPUTS[r->kind].f) {
    void *f = INPUTS[r->kind].f;
    switch (INPUTS[r->kind].call) {
      case I: ((void (*)(int32_t))f)(i); break;
      case D: ((void (*)(double))f)(d); break;
      case NI: ((void (*)(int32_t, int32_t))f)(n, i); break;
      case ND: ((void (*)(int32_t, double))f)(n, d); break;
      case NSI: ((void (*)(int32_t, int32_t, int32_t))f)(n, r->sub, i); break;
      default: ((void (*)(int32_t, int32_t, double))f)(n, r->sub, d); break;
    }
  } else if (r->kind == SIM_VALUE) write_value(n, d);
  else if (r->kind == NEW_DATA) new_data();
  else if (r->kind == CLOCK) (i ? resume_clock : pause_clock)();
  else if (r->kind == LOOK) put_choosers();
  else if (r->kind == END) _Exit(0);
  else if (r->kind == GOODBYE) { fprintf(stderr, "simcore: %.*s\n", (int)r->size, text); fflush(stderr); _Exit(1); }
  else if (r->kind == SELECT && set_string && memchr(text, 0, r->size)) {
    size_t key = strlen(text);
    struct text choice = {text + key + 1, r->size - key - 1};
    set_string(entry_at(text, key, "selected"), 0, &choice);
  } else if (r->kind >= FIRST_TEXT && r->kind - FIRST_TEXT < ROWS(TEXTS) && TEXTS[r->kind - FIRST_TEXT].f)
    ((void (*)(const struct text *))TEXTS[r->kind - FIRST_TEXT].f)(&string);
}

static void transfer(socket_t s, char *bytes, size_t size, int sends) {
  while (size) {
    int part = (int)(sends ? send(s, bytes, (int)size, 0) : recv(s, bytes, (int)size, 0));
    if (part <= 0) { complain("the connection is lost, the program ends", ""); _Exit(1); }
    bytes += part;
    size -= (size_t)part;
  }
}

static void answer(socket_t s) {
  struct header header = {{'S', 'C', 'B', VERSION}, 0, 0};
  int32_t status = 0;
  poll_ports();
  next_value = 0;
  each_device("", NULL, poll_device);
  put_errors();
  header.size = (uint32_t)(length - sizeof header);
  header.time = fpga_time(&status);
  memcpy(frame, &header, sizeof header);
  transfer(s, frame, length, 1);
  length = sizeof header;
}

static socket_t connect_to_simcore(int port) {
  struct sockaddr_in address;
  memset(&address, 0, sizeof address);
  address.sin_family = AF_INET;
  address.sin_port = htons((uint16_t)port);
  address.sin_addr.s_addr = htonl(0x7f000001);
  for (int tries = 0; tries < PATIENCE * 20; tries++) {
    socket_t s = socket(AF_INET, SOCK_STREAM, 0);
    int one = 1;
    if (s != INVALID_SOCKET && !connect(s, (struct sockaddr *)&address, sizeof address)) {
      setsockopt(s, IPPROTO_TCP, TCP_NODELAY, (char *)&one, sizeof one);
      return s;
    }
    if (s != INVALID_SOCKET) close_socket(s);
    if (tries == 20) complain("the program waits for `simcore serve`", "");
    sleep_ms(50);
  }
  complain("no `simcore serve` has come in a minute, the program ends", "");
  _Exit(1);
}

static void serve(void) {
  static char taken[LARGEST];
  struct header header;
#ifdef _WIN32
  WSADATA data;
  WSAStartup(0x0202, &data);
#endif
  socket_t s = connect_to_simcore(getenv("SIMCORE_PORT") ? atoi(getenv("SIMCORE_PORT")) : PORT);
  length = sizeof header;
#ifdef _WIN32
  put(PROCESS, 0, 0, (double)GetCurrentProcessId(), NULL, 0);
#else
  put(PROCESS, 0, 0, (double)getpid(), NULL, 0);
#endif
  answer(s);
  for (;;) {
    transfer(s, (char *)&header, sizeof header, 0);
    if (memcmp(header.magic, "SCB", 3) || header.magic[3] != VERSION || header.size > LARGEST) {
      complain("this extension is of another version than `simcore serve`; docs/java.md says where its own is", "");
      _Exit(1);
    }
    transfer(s, taken, header.size, 0);
    for (size_t at = 0; at + sizeof(struct record) <= header.size;) {
      struct record record;
      memcpy(&record, taken + at, sizeof record);
      at += sizeof record;
      if (at + record.size > header.size) break;
      take(&record, taken + at);
      at += record.size;
    }
    if (header.time) step_clock(header.time);
    answer(s);
  }
}

#ifdef _WIN32
static DWORD WINAPI run(LPVOID unused) { (void)unused; serve(); return 0; }
#else
static void *run(void *unused) { (void)unused; serve(); return NULL; }
#endif

EXPORT int HALSIM_InitExtension(void) {
  if (look_up()) return -1;
  pause_clock();
  set_error(note_error);
#ifdef _WIN32
  InitializeCriticalSection(&errors_lock);
  CreateThread(NULL, 0, run, NULL, 0, NULL);
#else
  pthread_t thread;
  pthread_create(&thread, NULL, run, NULL);
  pthread_detach(thread);
#endif
  return 0;
}
