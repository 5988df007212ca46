import static jdk.incubator.foreign.CLinker.C_DOUBLE;
import static jdk.incubator.foreign.CLinker.C_INT;
import static jdk.incubator.foreign.CLinker.C_LONG;
import static jdk.incubator.foreign.CLinker.C_POINTER;

import java.lang.invoke.MethodHandle;
import java.lang.invoke.MethodType;
import jdk.incubator.foreign.CLinker;
import jdk.incubator.foreign.FunctionDescriptor;
import jdk.incubator.foreign.MemoryAccess;
import jdk.incubator.foreign.MemoryAddress;
import jdk.incubator.foreign.MemoryLayout;
import jdk.incubator.foreign.MemorySegment;
import jdk.incubator.foreign.ResourceScope;
import jdk.incubator.foreign.SymbolLookup;

/** The tank of examples/cpp_tank on a JVM without WPILib's Java: its HAL by the foreign functions of JDK 17. */
public class HalTank {
  static final Class<?> I = int.class, D = double.class, J = long.class, V = void.class, A = MemoryAddress.class;

  static MethodHandle find(String name, Class<?> result, Class<?>... arguments) {
    MemoryLayout[] layouts = new MemoryLayout[arguments.length];
    for (int k = 0; k < arguments.length; k++) layouts[k] = layout(arguments[k]);
    FunctionDescriptor descriptor =
        result == V ? FunctionDescriptor.ofVoid(layouts) : FunctionDescriptor.of(layout(result), layouts);
    MemoryAddress address = SymbolLookup.loaderLookup().lookup(name).get();
    return CLinker.getInstance().downcallHandle(address, MethodType.methodType(result, arguments), descriptor);
  }

  static MemoryLayout layout(Class<?> type) {
    return type == I ? C_INT : type == D ? C_DOUBLE : type == J ? C_LONG : C_POINTER;
  }

  public static void main(String[] args) throws Throwable {
    for (String library : args) System.load(library);
    ResourceScope scope = ResourceScope.globalScope();
    MemoryAddress status = MemorySegment.allocateNative(4, scope).address();
    MemoryAddress name = CLinker.toCString("java", scope).address();
    MemorySegment word = MemorySegment.allocateNative(4, scope);
    int done = (int) find("HAL_Initialize", I, I, I).invokeExact(500, 0);
    MethodHandle port = find("HAL_GetPort", I, I), rate = find("HAL_GetEncoderRate", D, I, A);
    MethodHandle openInput = find("HAL_InitializeDIOPort", I, I, I, A, A);
    MethodHandle openEncoder = find("HAL_InitializeEncoder", I, I, I, I, I, I, I, A);
    MethodHandle setDistance = find("HAL_SetEncoderDistancePerPulse", V, I, D, A);
    MethodHandle openPwm = find("HAL_InitializePWMPort", I, I, A, A), set = find("HAL_SetPWMSpeed", V, I, D, A);
    MethodHandle setPulses = find("HAL_SetPWMConfigMicroseconds", V, I, I, I, I, I, I, A);
    int[] encoders = new int[2], motors = new int[2];
    for (int k = 0; k < 2; k++) {
      int a = (int) openInput.invokeExact((int) port.invokeExact(2 * k), 1, name, status);
      int b = (int) openInput.invokeExact((int) port.invokeExact(2 * k + 1), 1, name, status);
      encoders[k] = (int) openEncoder.invokeExact(a, 0, b, 0, 0, 2, status);
      setDistance.invokeExact(encoders[k], 0.000234, status);
      motors[k] = (int) openPwm.invokeExact((int) port.invokeExact(k), name, status);
      setPulses.invokeExact(motors[k], 2003, 1550, 1500, 1460, 999, status);
    }
    int notifier = (int) find("HAL_InitializeNotifier", I, A).invokeExact(status);
    MethodHandle alarm = find("HAL_UpdateNotifierAlarm", V, I, J, A);
    MethodHandle wait = find("HAL_WaitForNotifierAlarm", J, I, A);
    MethodHandle refresh = find("HAL_RefreshDSData", I), control = find("HAL_GetControlWord", I, A);
    long next = (long) find("HAL_GetFPGATime", J, A).invokeExact(status);
    find("HAL_ObserveUserProgramStarting", V).invokeExact();
    double[] goals = {1.0, 0.95};
    while (true) {
      next += 20000;
      alarm.invokeExact(notifier, next, status);
      if ((long) wait.invokeExact(notifier, status) == 0) break;
      done = (int) refresh.invokeExact();
      done = (int) control.invokeExact(word.address());
      boolean isEnabled = (MemoryAccess.getInt(word) & 1) != 0;
      for (int k = 0; k < 2; k++) {
        double now = (double) rate.invokeExact(encoders[k], status);
        set.invokeExact(motors[k], isEnabled ? 0.25 + 0.5 * (goals[k] - now) : 0.0, status);
      }
    }
  }
}
