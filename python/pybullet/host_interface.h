/// What PyBullet and a plugin of it call each other by, as far as this plugin needs it.
///
/// Only the order of the virtual functions and of the members counts, for these are the binary
/// interface of PyBullet 3 on Linux. So functions that do nothing here are declared without the
/// parameters that they do not look at: the caller of a function owns its arguments.
#ifndef PYTHON_PYBULLET_HOST_INTERFACE_H
#define PYTHON_PYBULLET_HOST_INTERFACE_H

class btDiscreteDynamicsWorld;

/// The number by which PyBullet 3.0.7 to 3.2.7 name this interface; pybullet.getAPIVersion().
inline constexpr int kHostApi = 202010061;

/// Is told by PyBullet what happens, so that it could be drawn. Does what PyBullet's own one does
/// in a client without a window, which is nothing.
class HostGraphics
{
public:
    HostGraphics() = default;
    HostGraphics(const HostGraphics&) = delete;
    HostGraphics& operator=(const HostGraphics&) = delete;
    virtual ~HostGraphics() = default;

    virtual void onRigidBody() {}
    virtual void onCollisionObject() {}
    virtual void onCollisionShape() {}
    virtual void onPosesOfWorld() {}
    virtual void onPosesOfWorldAgain() {}
    virtual void onPosesOfList() {}
    virtual void onRender() {}
    /// A world has been made, or this object has been set for a world. Null: there is no world.
    virtual void onWorld(btDiscreteDynamicsWorld* /*world*/) {}
    virtual int makeTexture() { return -1; }
    virtual int makeShape() { return -1; }
    virtual int makeInstance() { return -1; }
    /// The world is about to be destroyed, because the simulation is reset.
    virtual void onReset() {}
    virtual void onInstanceRemoved() {}
    virtual void onInstanceFlags() {}
    virtual void onColour() {}
    virtual void onScaling() {}
    virtual void onSpecularColour() {}
    virtual void onTextureChanged() {}
    virtual void onShapeChanged() {}
    virtual int shapeOfInstance() { return -1; }
    virtual void onTextureReplaced() {}
    virtual void onTextureRemoved() {}
    virtual void onBackground() {}
    virtual void* canvas() { return nullptr; }
    virtual void* parameters() { return nullptr; }
    virtual void* renderer() { return nullptr; }
    virtual const void* constRenderer() const { return nullptr; }
    virtual void* application() { return nullptr; }
    virtual void onUpAxis() {}
    virtual void onCameraReset() {}
    virtual bool camera() const { return false; }
    virtual void onVisualizerFlag() {}
    virtual void copyImage(
        const float*, const float*, unsigned char*, int, float*, int, int, int, int, int* copied)
    {
        nothingCopied(copied);
    }
    virtual void copyImageAndMask(const float*,
                                  const float*,
                                  unsigned char*,
                                  int,
                                  float*,
                                  int,
                                  int*,
                                  int,
                                  int,
                                  int,
                                  int,
                                  int* copied)
    {
        nothingCopied(copied);
    }
    virtual void onImage() {}
    virtual void onProjectiveMatrices() {}
    virtual void onProjectiveTexture() {}
    virtual void onAutomaticObjects() {}
    virtual void onText() {}
    virtual void onOrientedText() {}
    virtual int addText() { return -1; }
    virtual int addLine() { return -1; }
    virtual int addPoints() { return -1; }
    virtual int addParameter() { return -1; }
    virtual int readParameter() { return 0; }
    virtual void onItemRemoved() {}
    virtual void onAllItemsRemoved() {}
    virtual void onAllParametersRemoved() {}
    virtual void onFlagCallback() {}
    virtual void onVideo() {}
    virtual void onDrawLines() {}
    virtual void onClearLines() {}
    virtual bool isRemote() { return false; }

private:
    static void nothingCopied(int* copied)
    {
        if (copied != nullptr)
        {
            *copied = 0;
        }
    }
};

/// The part of PyBullet that owns the world and answers a client.
class HostProcessor
{
public:
    virtual ~HostProcessor() = default;
    virtual bool connect() = 0;
    virtual void disconnect() = 0;
    virtual bool isConnected() const = 0;
    virtual bool processCommand() = 0;
    virtual bool receiveStatus() = 0;
    virtual void renderScene() = 0;
    virtual void drawDebugLines() = 0;
    /// Tells `graphics`, which must not be null, the world that is there (onWorld()) and from then
    /// on what happens. It is not owned.
    virtual void setGraphics(HostGraphics* graphics) = 0;
};

/// What a function of a plugin is called with.
struct HostContext
{
    void* m_client;
    void* m_user;  ///< the plugin's own; kept between calls
    void* m_returned;
    const void* m_controllerEvents;
    int m_numControllerEvents;
    const void* m_keyEvents;
    int m_numKeyEvents;
    const void* m_mouseEvents;
    int m_numMouseEvents;
    const void* m_notifications;
    int m_numNotifications;
    HostProcessor* m_processor;  ///< null in exitPlugin and in ticks
};

/// What p.executePluginCommand(plugin, text, ints, floats) was called with.
struct HostArguments
{
    char m_text[1024];
    int m_numInts;
    int m_ints[128];
    int m_numFloats;
    double m_floats[128];
};

#endif  // PYTHON_PYBULLET_HOST_INTERFACE_H
