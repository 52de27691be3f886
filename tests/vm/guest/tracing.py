"""Plants faults into one thread of a running daemon: to stand still, or never to wait again."""
import contextlib
import ctypes
import os
import struct
import threading

PTRACE_POKETEXT, PTRACE_CONT, PTRACE_GETREGS, PTRACE_DETACH = 4, 7, 12, 17
PTRACE_SEIZE, PTRACE_INTERRUPT = 0x4206, 0x4207
WALL = 0x40000000
RIP = 16 * 8  # of user_regs_struct, x86-64
JUMP_TO_ITSELF = 0xFEEB

libc = ctypes.CDLL(None, use_errno=True)
libc.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
libc.ptrace.restype = ctypes.c_long


def ptrace(request, task, address=None, data=None):
    if libc.ptrace(request, task, address, data) == -1:
        raise OSError(ctypes.get_errno(), f"ptrace {request:#x} of {task}")


def stopped(task):
    ptrace(PTRACE_SEIZE, task)
    ptrace(PTRACE_INTERRUPT, task)
    os.waitpid(task, WALL)


def until_gone(task):
    """Whoever traces a thread must reap it, else its process never ends."""
    try:
        while True:
            _, status = os.waitpid(task, WALL)
            if os.WIFEXITED(status) or os.WIFSIGNALED(status):
                return
            if os.WIFSTOPPED(status):
                ptrace(PTRACE_CONT, task, None, ctypes.c_void_p(os.WSTOPSIG(status)))
    except OSError:
        return


def in_thread(work):
    """ptrace belongs to the thread that has called it, so all of it happens in one."""
    began, failure = threading.Event(), []

    def body():
        try:
            reap = work()
        except OSError as error:
            failure.append(error)
            reap = None
        began.set()
        if reap:
            until_gone(reap)

    thread = threading.Thread(target=body, daemon=True)
    thread.start()
    began.wait()
    if failure:
        raise failure[0]


def stall(task):
    """The thread stands still for ever; the rest of its process goes on."""
    def work():
        stopped(task)
        return task
    in_thread(work)


def spin(task):
    """When the thread's wait returns, it jumps to where it stands, for ever."""
    def work():
        stopped(task)
        registers = ctypes.create_string_buffer(27 * 8)
        ptrace(PTRACE_GETREGS, task, None, registers)
        address = struct.unpack_from("<Q", registers, RIP)[0]
        with open(f"/proc/{task}/mem", "r+b", buffering=0) as memory:
            memory.seek(address)
            memory.write(struct.pack("<H", JUMP_TO_ITSELF))
        # Other threads wait at the same place: one that returned meanwhile jumps already, and may have ended the process.
        with contextlib.suppress(ProcessLookupError):
            ptrace(PTRACE_DETACH, task)
    in_thread(work)
