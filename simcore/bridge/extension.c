/* simcore's bridge: an extension of WPILib's simulated HAL that lets another process step a robot program.
 *
 * It links to nothing of WPILib: every function is looked up in the running program, whatever language that is written
 * in. HALSIM_InitExtension pauses the program's clock; a thread connects to 127.0.0.1:$SIMCORE_PORT (9810). The first
 * frame from there names the functions that write sensors and driver station, and those that are asked; each frame
 * writes, steps the clock, and is answered with what has changed. docs/bridge.md describes the frames.
 */
#define _GNU_SOURCE
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef _WIN32
#include <winsock2.h>
#include <windows.h>
#define EXPORT __declspec(dllexport)
#define sleep_ms Sleep
#define process_id GetCurrentProcessId
typedef SOCKET socket_t;
#else
#include <arpa/inet.h>
#include <dlfcn.h>
#include <netinet/tcp.h>
#include <pthread.h>
#include <sys/socket.h>
#include <unistd.h>
#define EXPORT __attribute__((visibility("default")))
#define sleep_ms(ms) usleep((ms) * 1000)
#define closesocket close
#define process_id getpid
typedef int socket_t;
#endif
#ifdef __APPLE__
#include <mach-o/dyld.h>
#elif !defined(_WIN32)
#include <link.h>
#endif

#define VERSION '1'
enum { PORT = 9810, PATIENCE = 60, LARGEST = 1 << 20, VALUES = 2048, KINDS = 96 }; /* seconds, bytes of a frame, rows */
enum { DEFINE_INPUT = 96, DEFINE_OUTPUT, SIM_VALUE = 100, NEW_DATA, CLOCK, END, LOOK, PROCESS };
enum { VALUE_NAME = 128, CHOOSER, ERROR_TEXT, SELECT = 138 };
/* What a function takes: index (N), second index (S), and integer (I), number (D) or text (T); what it returns: I or D. */
enum call { I, D, NI, ND, NSI, NSD, T };

struct header { char magic[4]; uint32_t size; uint64_t time; }; /* `size` bytes of records follow; time in microseconds */
struct record { uint8_t kind, sub; uint16_t size; int32_t number; double value; }; /* `size` bytes of text follow */
struct text { const char *str; size_t len; };                                      /* WPI_String */
struct sim_value { union { int32_t i; int64_t l; double d; } data; enum { DOUBLE_TYPE = 2, LONG_TYPE = 16 } type; };

/* --- functions of the program ------------------------------------------------------------------------------------- */

#ifdef _WIN32
static void *find(const char *name) {
  const char *modules[] = {"wpiHal.dll", "wpiHald.dll", "ntcore.dll", "ntcored.dll", NULL};
  void *found = NULL;
  for (int i = 0; !found && i < 5; i++) found = (void *)GetProcAddress(GetModuleHandleA(modules[i]), name);
  return found;
}
#else
/* Java and Python load WPILib for themselves alone (RTLD_LOCAL), so its libraries are asked one by one. */
static const char *libraries[64];
static int count_libraries;
static void note_library(const char *path) {
  const char *file = path ? strrchr(path, '/') : NULL;
  if (file && (strstr(file, "wpiHal") || strstr(file, "ntcore")) && count_libraries < 64) libraries[count_libraries++] = path;
}
#ifdef __APPLE__
static void note_libraries(void) { for (uint32_t i = 0; i < _dyld_image_count(); i++) note_library(_dyld_get_image_name(i)); }
#else
static int note_object(struct dl_phdr_info *info, size_t n, void *p) { return (void)n, (void)p, note_library(info->dlpi_name), 0; }
static void note_libraries(void) { dl_iterate_phdr(note_object, NULL); }
#endif
static void *find(const char *name) {
  void *found = dlsym(RTLD_DEFAULT, name);
  if (!count_libraries) note_libraries();
  for (int i = 0; !found && i < count_libraries; i++) {
    void *library = dlopen(libraries[i], RTLD_LAZY | RTLD_NOLOAD);
    found = library ? dlsym(library, name) : NULL;
  }
  return found;
}
#endif

typedef void (*device_f)(const char *, void *, int32_t);
typedef void (*value_f)(const char *, void *, int32_t, int32_t, const struct sim_value *);
typedef int32_t (*error_f)(int32_t, int32_t, int32_t, const char *, const char *, const char *, int32_t);
#define FUNCTIONS(X) \
  X(void, HALSIM_PauseTiming, (void)) X(void, HALSIM_ResumeTiming, (void)) X(void, HALSIM_StepTiming, (uint64_t)) \
  X(void, HALSIM_NotifyDriverStationNewData, (void)) X(uint64_t, HAL_GetFPGATime, (int32_t *)) \
  X(void, HALSIM_SetSendError, (error_f)) X(void, HALSIM_EnumerateSimDevices, (const char *, void *, device_f)) \
  X(void, HALSIM_EnumerateSimValues, (int32_t, void *, value_f)) X(void, HAL_GetSimValue, (int32_t, struct sim_value *)) \
  X(void, HAL_SetSimValue, (int32_t, const struct sim_value *)) X(int32_t, NT_GetDefaultInstance, (void)) \
  X(int32_t *, NT_GetTopics, (int32_t, const struct text *, unsigned, size_t *)) \
  X(void, NT_GetTopicName, (int32_t, struct text *)) X(int32_t, NT_GetEntry, (int32_t, const struct text *)) \
  X(void, NT_GetString, (int32_t, const struct text *, struct text *)) \
  X(int32_t, NT_SetString, (int32_t, int64_t, const struct text *)) \
  X(struct text *, NT_GetStringArray, (int32_t, const struct text *, size_t, size_t *))
#define DECLARE(type, name, arguments) static type(*name) arguments;
#define ROW(type, name, arguments) {#name, &name},
FUNCTIONS(DECLARE)
static const struct { const char *name; void *place; } functions[] = {FUNCTIONS(ROW)};

static int complain(const char *sentence, const char *name) {
  fprintf(stderr, "simcore: %s%s\n", sentence, name);
  return fflush(stderr) - 1;
}

/* A program without NetworkTables has no choosers; all else is needed. */
static int look_up(void) {
  for (unsigned i = 0; i < sizeof functions / sizeof *functions; i++) {
    void *found = find(functions[i].name);
    if (!found && functions[i].name[0] == 'H') return complain("this program's WPILib has no ", functions[i].name);
    memcpy(functions[i].place, &found, sizeof found);
  }
  return 0;
}

/* --- what the program does ---------------------------------------------------------------------------------------- */

static struct row { int call, count, subs; void *f; double *last; } inputs[KINDS], outputs[KINDS];
static int count_outputs;
static struct { int32_t handle; double value; } values[VALUES];
static int count_values;
static char frame[LARGEST + 65536], errors[16384]; /* texts of errors, each with a zero behind it */
static size_t length, errors_length;
static char errors_lock;
#define LOCK() while (__atomic_test_and_set(&errors_lock, __ATOMIC_ACQUIRE))
#define UNLOCK() __atomic_clear(&errors_lock, __ATOMIC_RELEASE)

static void put(int kind, int sub, int32_t number, double value, const char *text, size_t size) {
  struct record record = {(uint8_t)kind, (uint8_t)sub, (uint16_t)size, number, value};
  if (size > 65535 || length + sizeof record + size > sizeof frame) return;
  memcpy(frame + length, &record, sizeof record);
  if (size) memcpy(frame + length + sizeof record, text, size);
  length += sizeof record + size;
}

/* Second indices are asked of those that the row before has as in use: solenoids of the modules that there are. */
static void poll_ports(void) {
  for (int row = 0; row < count_outputs; row++)
    for (int n = 0; outputs[row].f && n < outputs[row].count; n++)
      for (int s = 0; s < outputs[row].subs; s++) {
        double *last = outputs[row].last + n * outputs[row].subs + s, now;
        void *f = outputs[row].f;
        if (outputs[row].call == NSI && !outputs[row - 1].last[n]) break;
        if (outputs[row].call == I) now = ((int32_t(*)(void))f)();
        else if (outputs[row].call == NI) now = ((int32_t(*)(int32_t))f)(n);
        else if (outputs[row].call == ND) now = ((double (*)(int32_t))f)(n);
        else now = ((int32_t(*)(int32_t, int32_t))f)(n, s);
        if (now != *last) put(row, s, n, *last = now, NULL, 0);
      }
}

static void poll_value(const char *name, void *device, int32_t handle, int32_t direction, const struct sim_value *value) {
  double now = value->type == DOUBLE_TYPE ? value->data.d : value->type == LONG_TYPE ? (double)value->data.l : value->data.i;
  int row = 0;
  (void)direction;
  while (row < count_values && values[row].handle != handle) row++;
  if (row == VALUES) return;
  if (row == count_values) {
    char text[512];
    int size = snprintf(text, sizeof text, "%s%c%s", (const char *)device, 0, name);
    values[count_values++].handle = handle;
    put(VALUE_NAME, value->type, handle, now, text, size < (int)sizeof text ? (size_t)size : sizeof text - 1);
  } else if (now != values[row].value) put(SIM_VALUE, 0, handle, now, NULL, 0);
  values[row].value = now;
}

static void poll_device(const char *name, void *p, int32_t handle) { (void)p, HALSIM_EnumerateSimValues(handle, (void *)name, poll_value); }

static int32_t note_error(int32_t is_error, int32_t code, int32_t is_labview, const char *details, const char *location,
                          const char *stack, int32_t prints) {
  size_t size = strlen(details) + 1;
  (void)code, (void)is_labview;
  LOCK();
  if (errors_length + size <= sizeof errors) memcpy(errors + errors_length, details, size), errors_length += size;
  UNLOCK();
  if (prints) fprintf(stderr, "%s at %s: %s\n%s%s", is_error ? "Error" : "Warning", location, details, stack, *stack ? "\n" : "");
  return 0;
}

static void put_errors(void) {
  LOCK();
  for (size_t at = 0, size; at < errors_length; at += size + 1) put(ERROR_TEXT, 0, 0, 0, errors + at, size = strlen(errors + at));
  errors_length = 0;
  UNLOCK();
}

/* --- choosers on the dashboard ------------------------------------------------------------------------------------ */

static int32_t entry_at(const char *key, size_t size, const char *name) {
  char full[512];
  snprintf(full, sizeof full, "%.*s/%s", (int)size, key, name);
  return NT_GetEntry(NT_GetDefaultInstance(), &(struct text){full, strlen(full)});
}

/* A chooser is a row of texts: key, type, default, active, options. WPILib's copies of them stay in memory. */
static void put_choosers(void) {
  const char *names[] = {".type", "default", "active"};
  struct text prefix = {"/", 1}, nothing = {"", 0}, key, value, *list;
  size_t count = 0, options = 0;
  int32_t *found = NT_GetDefaultInstance && NT_GetTopics ? NT_GetTopics(NT_GetDefaultInstance(), &prefix, 0, &count) : NULL;
  for (size_t i = 0; i < count; i++) {
    NT_GetTopicName(found[i], &key);
    if (key.len <= 8 || memcmp(key.str + key.len - 8, "/options", 8)) continue;
    put(CHOOSER, 0, 0, 0, key.str, key.len -= 8);
    for (int k = 0; k < 3; k++) {
      NT_GetString(entry_at(key.str, key.len, names[k]), &nothing, &value);
      put(CHOOSER, 1, 0, 0, value.str, value.len);
    }
    list = NT_GetStringArray(entry_at(key.str, key.len, "options"), NULL, 0, &options);
    for (size_t k = 0; k < options; k++) put(CHOOSER, 1, 0, 0, list[k].str, list[k].len);
  }
}

/* --- what simcore says -------------------------------------------------------------------------------------------- */

static void define(const struct record *r, const char *text) {
  struct row *row = r->kind == DEFINE_INPUT ? &inputs[r->number % KINDS] : &outputs[count_outputs++ % KINDS];
  char name[128];
  snprintf(name, sizeof name, "HALSIM_%.*s", (int)r->size, text);
  row->call = r->sub, row->f = find(name), row->count = r->number, row->subs = (int)r->value;
  if (r->kind == DEFINE_OUTPUT) row->last = calloc((size_t)(row->count * row->subs), sizeof(double));
}

static void write_value(int32_t handle, double number) {
  struct sim_value value = {{0}, 0};
  HAL_GetSimValue(handle, &value);
  if (value.type == DOUBLE_TYPE) value.data.d = number;
  else if (value.type == LONG_TYPE) value.data.l = (int64_t)number;
  else value.data.i = (int32_t)number;
  HAL_SetSimValue(handle, &value);
}

static void write_input(int call, void *f, const struct record *r, const char *text) {
  int32_t n = r->number, i = (int32_t)(int64_t)r->value; /* by way of 64 bits: a mask of buttons has no sign */
  if (call == I) ((void (*)(int32_t))f)(i);
  else if (call == D) ((void (*)(double))f)(r->value);
  else if (call == NI) ((void (*)(int32_t, int32_t))f)(n, i);
  else if (call == ND) ((void (*)(int32_t, double))f)(n, r->value);
  else if (call == NSI) ((void (*)(int32_t, int32_t, int32_t))f)(n, r->sub, i);
  else if (call == NSD) ((void (*)(int32_t, int32_t, double))f)(n, r->sub, r->value);
  else ((void (*)(const struct text *))f)(&(struct text){text, r->size});
}

static void take(const struct record *r, const char *text) {
  if (r->kind < KINDS && inputs[r->kind].f) write_input(inputs[r->kind].call, inputs[r->kind].f, r, text);
  else if (r->kind == DEFINE_INPUT || r->kind == DEFINE_OUTPUT) define(r, text);
  else if (r->kind == SIM_VALUE) write_value(r->number, r->value);
  else if (r->kind == NEW_DATA) HALSIM_NotifyDriverStationNewData();
  else if (r->kind == CLOCK) (r->value != 0.0 ? HALSIM_ResumeTiming : HALSIM_PauseTiming)();
  else if (r->kind == LOOK) put_choosers();
  else if (r->kind == END) _Exit(0);
  else if (r->kind == SELECT && NT_SetString && memchr(text, 0, r->size)) {
    size_t key = strlen(text);
    struct text choice = {text + key + 1, r->size - key - 1};
    NT_SetString(entry_at(text, key, "selected"), 0, &choice);
  }
}

/* --- the connection ----------------------------------------------------------------------------------------------- */

static void transfer(socket_t s, char *bytes, size_t size, int sends) {
  while (size) {
    int part = (int)(sends ? send(s, bytes, (int)size, 0) : recv(s, bytes, (int)size, 0));
    if (part <= 0) complain("the connection is lost, the program ends", ""), _Exit(1);
    bytes += part, size -= (size_t)part;
  }
}

static void answer(socket_t s) {
  struct header header = {{'S', 'C', 'B', VERSION}, 0, 0};
  poll_ports();
  HALSIM_EnumerateSimDevices("", NULL, poll_device);
  put_errors();
  header.size = (uint32_t)(length - sizeof header);
  header.time = HAL_GetFPGATime(&(int32_t){0});
  memcpy(frame, &header, sizeof header);
  transfer(s, frame, length, 1);
  length = sizeof header;
}

static socket_t connect_to_simcore(int port) {
  struct sockaddr_in address = {.sin_family = AF_INET, .sin_port = htons((uint16_t)port), .sin_addr.s_addr = htonl(0x7f000001)};
  int one = 1;
  for (int tries = 0; tries < PATIENCE * 20; tries++) {
    socket_t s = socket(AF_INET, SOCK_STREAM, 0);
    if (!connect(s, (struct sockaddr *)&address, sizeof address))
      return setsockopt(s, IPPROTO_TCP, TCP_NODELAY, (char *)&one, sizeof one), s;
    closesocket(s);
    if (tries == 20) complain("the program waits for `simcore serve`", "");
    sleep_ms(50);
  }
  complain("no `simcore serve` has come in a minute, the program ends", "");
  _Exit(1);
}

static void serve(void) {
  static char taken[LARGEST + 1];
  struct header header;
  struct record record;
#ifdef _WIN32
  WSADATA data;
  WSAStartup(0x0202, &data);
#endif
  socket_t s = connect_to_simcore(getenv("SIMCORE_PORT") ? atoi(getenv("SIMCORE_PORT")) : PORT);
  length = sizeof header;
  put(PROCESS, 0, 0, (double)process_id(), NULL, 0);
  for (;;) {
    answer(s);
    transfer(s, (char *)&header, sizeof header, 0);
    if (memcmp(header.magic, "SCB", 3) || header.magic[3] != VERSION || header.size > LARGEST)
      complain("this extension is of another version than `simcore serve`; docs/java.md says where its own is", ""), _Exit(1);
    transfer(s, taken, header.size, 0);
    taken[header.size] = 0;
    for (size_t at = 0; at + sizeof record <= header.size; at += sizeof record + record.size) {
      memcpy(&record, taken + at, sizeof record);
      if (at + sizeof record + record.size <= header.size) take(&record, taken + at + sizeof record);
    }
    if (header.time) HALSIM_StepTiming(header.time);
  }
}

#ifdef _WIN32
static DWORD WINAPI run(LPVOID unused) { serve(); return unused != NULL; }
#else
static void *run(void *unused) { serve(); return unused; }
#endif
#ifdef __linux__
/* A program that ends would take the HAL apart under the thread that steps it, and its status would be that of a crash. */
static void leave(int status, void *unused) { (void)unused, fflush(NULL), _exit(status); }
#else
#define on_exit(call, argument)
#endif

EXPORT int HALSIM_InitExtension(void) {
  if (look_up()) return -1;
  HALSIM_PauseTiming(), HALSIM_SetSendError(note_error);
  on_exit(leave, NULL);
#ifdef _WIN32
  CreateThread(NULL, 0, run, NULL, 0, NULL);
#else
  pthread_t thread;
  if (!pthread_create(&thread, NULL, run, NULL)) pthread_detach(thread);
#endif
  return 0;
}
